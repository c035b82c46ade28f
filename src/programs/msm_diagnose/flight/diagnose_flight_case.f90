! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the `flusi` case of an experiment and derives cases from it with other kinematics, another flow or a finer grid. A
!> derived case is an ini file that includes the case and sets the keys that change. All ranks hold the same.
module diagnose_flight_case
  use base_build, only: BUILD_COMMIT, BUILD_VERSION
  use base_checksum, only: checksum_text
  use base_errors, only: message_list_t
  use base_files, only: folder_of, join_path, name_of, real_path
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnose_flight_landmarks, only: flight_marks_t
  use diagnose_flight_omitted, only: omission_fault, omitted_t, omitted_text, why_not_added, JUDGED
  use diagnose_flight_refined, only: flown_beats, refined_error_over_change, refined_text, three, why_unrefined
  use diagnose_flight_structure, only: structure_text
  use diagnosis_flight_refinements, only: N_REFINEMENTS
  use diagnosis_flight_runner, only: flight_facts_t, flight_request_t, N_PHASES
  use diagnosis_flight_changes, only: FLOW_DEVIATION, FLOW_DEVIATION_COS, FLOW_DEVIATION_SIN, FLOW_LEAD, &
                                      FLOW_AREA, FLOW_PITCH, FLOW_PITCH_MEAN, FLOW_PLANE, FLOW_PLATE, FLOW_STROKE, &
                                      FLOW_STROKE_MEAN, FLOW_STRUCTURE, FLOW_VISCOSITY, FLOW_WIND, FLOW_YOUNG
  use diagnosis_wing_parameters, only: wing_parameter_t
  use fluid_mean_keys, only: MEAN_FIXED
  use fsi_body_motion, only: MOTION_TABLE
  use fsi_body_motion_keys, only: body_motion_choices, body_motion_choices_t
  use fsi_kinematics, only: body_t, pose_wing, wing_pose_t
  use fsi_kinematics_keys, only: kinematics_choices, kinematics_choices_t
  use fsi_rotation, only: cross
  use io_broadcast_text, only: read_broadcast_text
  use measurement_flight, only: N_COMPONENTS
  use parallel_world, only: world_t
  use simulation_plans, only: expected_steps
  use simulation_settings, only: load_settings, settings_t
  implicit none
  private
  public :: flight_case_t

  real(rp), parameter :: LARGER = 0.1_rp     !< logarithm of the area of wings that must fit into the box
  real(rp), parameter :: SECONDS = 6.0e-7_rp !< of one step for each point on one rank, roughly
  character(*), parameter :: NL = new_line('a')

  type :: flight_case_t
    character(:), allocatable :: path         !< from the root
    integer :: beats = 1                      !< number of simulated beats
    type(settings_t) :: settings              !< of the given case
    type(omitted_t) :: omitted                !< what a user states of things that it leaves out
    real(rp) :: wing_thickness = 0            !< [L] of the wings of the experiment; 0: not known
    type(wing_parameter_t), allocatable :: structure(:) !< what the changes of the structure are
    type(flight_marks_t) :: marks             !< landmarks whose places are wanted
    type(kinematics_choices_t) :: kinematics
    type(body_motion_choices_t) :: body
  contains
    procedure :: load => case_load
    procedure :: tell => case_tell
    procedure :: text => case_text
    procedure :: name => case_name
    procedure :: read => case_read
    procedure :: fingerprint => case_fingerprint
    procedure :: judge => case_judge
  end type flight_case_t

contains

  !> Reads the case at `path`. Mistakes go to `errors` and remarks to `notices`. Collective.
  subroutine case_load(self, path, beats, world, errors, notices)
    class(flight_case_t), intent(inout) :: self
    character(*), intent(in) :: path
    integer, intent(in) :: beats
    type(world_t), intent(in) :: world
    type(message_list_t), intent(inout) :: errors, notices
    character(:), allocatable :: text, problem
    integer :: before
    before = errors%count()
    self%path = real_path(path)
    call world%broadcast_text(self%path)
    self%beats = beats
    call read_broadcast_text(self%path, text, problem, world)
    if (allocated(problem)) then
      call errors%add(problem)
      return
    end if
    call load_settings(text, self%path, .false., self%settings, errors, notices, world)
    if (errors%count() > before) return
    associate (s => self%settings)
      if (.not. s%units%given) call errors%add(self%path//': [units] is missing: give length, frequency and density, '// &
                                               'so that forces can be compared in newtons')
      if (.not. s%fluid%solids%is_moving .or. .not. allocated(s%flight%wings)) &
        call errors%add(self%path//': has no flapping wings; set [Penalization] iMask = Insect')
      if (s%flight%flyer%is_free) call errors%add(self%path//': is a free flight, but a wing on a balance is tethered; set '// &
                                                  '[Insects] BodyMotion = tethered')
      if (.not. s%fluid%solids%compute_forces) call errors%add(self%path//': computes no forces; set [Penalization] '// &
                                                               'compute_forces = yes')
      if (errors%count() > before) return
      self%kinematics = kinematics_choices(s%config)
      self%body = body_motion_choices(s%config)
    end associate
  end subroutine case_load

  !> Fills `facts` with what is known about the case before any flight.
  subroutine case_tell(self, facts)
    class(flight_case_t), intent(in) :: self
    type(flight_facts_t), intent(inout) :: facts
    real(rp) :: dt, speed
    logical :: has_table
    associate (s => self%settings, u => self%settings%units)
      facts%path = self%path
      facts%is_section = s%fluid%grid%is_2d
      facts%is_flexible = s%flexible
      facts%frequency = s%flight%frequency()*u%frequency
      facts%speed = (s%flight%tip_speed() + s%flight%motion%mean_speed())*u%length*u%frequency
      facts%wind = s%fluid%mean%velocity*u%length*u%frequency
      facts%along = drag_direction(s)
      has_table = s%flight%motion%kind == MOTION_TABLE
      facts%missing = ''
      if (facts%is_section) then
        if (.not. has_table) facts%missing(FLOW_STROKE) = 'needs a plate whose motion is a table'
        facts%missing(FLOW_STROKE_MEAN) = 'needs a wing that turns about a hinge, and this case is a section'
        facts%missing([FLOW_DEVIATION, FLOW_DEVIATION_COS, FLOW_DEVIATION_SIN]) = facts%missing(FLOW_STROKE_MEAN)
        facts%missing(FLOW_PLANE) = facts%missing(FLOW_STROKE_MEAN)
        facts%missing(FLOW_WIND + 1) = 'needs a three-dimensional flow, and this case is a section'
      end if
      if (facts%missing(FLOW_DEVIATION) == '' .and. .not. deviates(s)) &
        facts%missing(FLOW_DEVIATION) = 'the kinematics have no deviation whose amplitude could differ'
      if (any(s%fluid%mean%kind /= MEAN_FIXED)) facts%missing(FLOW_WIND + 1:FLOW_WIND + 3) = &
        'needs a prescribed mean flow: [MeanFlow] iMeanFlow = 1'
      if (s%flexible) then
        facts%material(:2) = material_of(self)
      else
        facts%missing([FLOW_YOUNG, FLOW_PLATE]) = 'needs wings that bend'
      end if
      call expected_steps(s, dt, speed, facts%steps)
      facts%steps = self%beats/s%flight%frequency()/dt
      facts%seconds = facts%steps*product(real(s%fluid%grid%n, rp))*SECONDS
    end associate
    call find_inertia(self, facts%inertia)
  end subroutine case_tell

  !> Returns the unit vector along which drag points: the horizontal mean flow or, without one, x; in a section y.
  pure function drag_direction(s) result(along)
    type(settings_t), intent(in) :: s
    real(rp) :: along(3)
    along = [s%fluid%mean%velocity(1:2), 0.0_rp]
    if (s%fluid%grid%is_2d) along(1) = 0
    if (norm2(along) <= 0) along = merge([0, 1, 0], [1, 0, 0], s%fluid%grid%is_2d)
    along = along/norm2(along)
  end function drag_direction

  !> Tells whether any wing leaves its stroke plane by an angle that varies.
  pure logical function deviates(s)
    type(settings_t), intent(in) :: s
    integer, parameter :: N = 20
    real(rp), parameter :: LEAST = 1.0e-6_rp !< rad
    real(rp) :: f(0:2, N), limits(2)
    integer :: w, i
    deviates = .false.
    do w = 1, size(s%flight%wings)
      associate (theta => s%flight%wings(w)%motion%theta)
        limits = theta%typical_cycle()
        do i = 1, N
          call theta%evaluate(limits(1) + (limits(2) - limits(1))*i/N, f(:, i))
        end do
      end associate
      deviates = deviates .or. maxval(f(0, :)) - minval(f(0, :)) > LEAST
    end do
  end function deviates

  !> Fills `facts` with why changes cannot be made that only the reader of the case can judge, and why numerical errors cannot be
  !> made smaller, and else with what the flights for it cost, in flights of the case. Only the refinements `wanted` are judged.
  !> Collective.
  subroutine case_judge(self, wanted, world, facts)
    class(flight_case_t), intent(in) :: self
    logical, intent(in) :: wanted(N_REFINEMENTS)
    type(world_t), intent(in) :: world
    type(flight_facts_t), intent(inout) :: facts
    type(settings_t), allocatable :: settings
    type(message_list_t) :: errors
    type(flight_request_t) :: request
    integer :: i, k
    do i = 1, size(JUDGED)
      k = JUDGED(i)
      facts%missing(k) = why_not_added(self%settings, self%omitted, k)
      if (facts%missing(k) /= '') cycle
      request = flight_request_t()
      request%change(k) = 1
      if (k == FLOW_AREA) request%change(k) = LARGER
      if (allocated(settings)) deallocate (settings)
      allocate (settings)
      errors = message_list_t()
      call self%read(request, settings, errors, world)
      if (errors%count() > 0) facts%missing(k) = errors%text(1)
    end do
    request = flight_request_t()
    do k = 1, N_REFINEMENTS
      if (.not. wanted(k)) cycle
      facts%unrefined(k) = why_unrefined(self%settings, k, self%wing_thickness)
      if (facts%unrefined(k) /= '') cycle
      request%refinement = k
      if (allocated(settings)) deallocate (settings)
      allocate (settings)
      errors = message_list_t()
      call self%read(request, settings, errors, world)
      if (errors%count() > 0) then
        facts%unrefined(k) = errors%text(1)
      else
        facts%cost(k) = cost_of(settings, flown_beats(self%beats, k))/cost_of(self%settings, self%beats)
        facts%error_over_change(k) = refined_error_over_change(self%settings, k, self%wing_thickness)
      end if
    end do
  end subroutine case_judge

  !> Returns the number of steps of a flight times its points.
  real(rp) function cost_of(settings, beats) result(cost)
    type(settings_t), intent(in) :: settings
    integer, intent(in) :: beats
    real(rp) :: dt, speed, steps
    call expected_steps(settings, dt, speed, steps)
    cost = beats/(settings%flight%frequency()*dt)*product(real(settings%fluid%grid%n, rp))
  end function cost_of

  !> Finds the inertia over the beat: the forces [m/s^2] and the torques about the origin [m^2/s^2] on what holds the wings, per
  !> unit mass of all wings. The mass is spread evenly over the area of the wings. Bending is left out.
  subroutine find_inertia(self, inertia)
    class(flight_case_t), intent(in) :: self
    real(rp), intent(out) :: inertia(N_PHASES, N_COMPONENTS)
    type(body_t) :: body
    type(wing_pose_t) :: pose
    real(rp) :: t, centroid(3), force(3), at(3)
    integer :: i, w
    inertia = 0
    associate (s => self%settings, u => self%settings%units)
      do i = 1, N_PHASES
        t = (self%beats - 1 + real(i - 1, rp)/N_PHASES)/s%flight%frequency()
        do w = 1, size(s%flight%wings)
          associate (wing => s%flight%wings(w))
            centroid = centroid_of(wing%points, wing%triangles)
            body = s%flight%motion%at(t, s%flight%body)
            call pose_wing(body, wing%mount, wing%motion, t, pose)
            at = pose%point_to_space(centroid)
            force = -pose%acceleration_at(centroid)/size(s%flight%wings)
            inertia(i, 1:3) = inertia(i, 1:3) + force*u%length*u%frequency**2
            inertia(i, 4:6) = inertia(i, 4:6) + cross(at, force)*(u%length*u%frequency)**2
          end associate
        end do
      end do
    end associate
  end subroutine find_inertia

  !> Returns the centroid of a surface.
  pure function centroid_of(points, triangles) result(centroid)
    real(rp), intent(in) :: points(:, :)
    integer, intent(in) :: triangles(:, :)
    real(rp) :: centroid(3), area, total
    integer :: k
    centroid = 0
    total = 0
    do k = 1, size(triangles, 2)
      associate (a => points(:, triangles(1, k)), b => points(:, triangles(2, k)), c => points(:, triangles(3, k)))
        area = norm2(cross(b - a, c - a))/2
        centroid = centroid + area*(a + b + c)/3
        total = total + area
      end associate
    end do
    if (total > 0) centroid = centroid/total
  end function centroid_of

  !> Returns the text of the ini file of a flight.
  function case_text(self, request) result(text)
    class(flight_case_t), intent(in) :: self
    type(flight_request_t), intent(in) :: request
    character(:), allocatable :: text
    real(rp) :: length, time, period, interval
    associate (s => self%settings, u => self%settings%units, c => request%change)
      length = merge(u%length, 1.0_rp, u%si_input)       ! of one L in the file
      time = merge(1/u%frequency, 1.0_rp, u%si_input)
      period = 1/s%flight%frequency()
      interval = period/N_PHASES
      text = '; The case with other keys, by msm_diagnose. Files that the case names are beside the case.'//NL// &
             '[include]'//NL//'file = '//self%path//NL//NL// &
             '[Time]'//NL//'Tmax = '//number_text(flown_beats(self%beats, request%refinement)*period*time)//NL
      if (s%fluid%time%has_nt) text = text//'nt = 1000000000'//NL
      text = text//'[Saving]'//NL//'tintegral = '//number_text(interval*time)//NL// &
             self%marks%text(u%length/length)//refined_text(s, request%refinement, length, time, self%wing_thickness)// &
             omitted_text(s, self%omitted, c, length)
      if (abs(c(FLOW_VISCOSITY)) > 0) text = text//'[ReynoldsNumber]'//NL//'nu = '// &
        number_text(s%fluid%nu*exp(c(FLOW_VISCOSITY))*length**2/time)//NL
      if (any(abs(c(FLOW_WIND + 1:FLOW_WIND + 3)) > 0)) text = text//'[MeanFlow]'//NL// &
        numbers([character(4) :: 'ux', 'uy', 'uz'], (s%fluid%mean%velocity + c(FLOW_WIND + 1:FLOW_WIND + 3)/ &
                                                     (u%length*u%frequency))*length/time)
    end associate
    text = text//kinematics_text(self, request)
    if (any(abs(request%change([FLOW_YOUNG, FLOW_PLATE])) > 0)) text = text//'[Wing]'//NL// &
      numbers(['E', 'D'], exp(request%change([FLOW_YOUNG, FLOW_PLATE]))*material_of(self))
    if (allocated(self%structure)) text = text//structure_text(self%settings, self%structure, request%change(FLOW_STRUCTURE + 1:))
    if (allocated(request%wing)) text = text//NL//request%wing
  end function case_text

  !> Returns the lines of [Insects] that change the kinematics as requested.
  function kinematics_text(self, request) result(text)
    class(flight_case_t), intent(in) :: self
    type(flight_request_t), intent(in) :: request
    character(:), allocatable :: text
    real(rp) :: factor(3), offset(3), lead(3)
    integer :: pitch
    factor = self%kinematics%factor
    offset = self%kinematics%offset
    lead = self%kinematics%lead
    pitch = merge(1, 2, self%settings%fluid%grid%is_2d)
    text = NL//'[Insects]'//NL
    associate (c => request%change)
      if (self%settings%fluid%grid%is_2d) then
        if (abs(c(FLOW_STROKE)) > 0) text = text//'body_motion_factor = '//number_text(self%body%factor*(1 + c(FLOW_STROKE)))//NL
      else
        factor(1) = factor(1)*(1 + c(FLOW_STROKE))
        offset(1) = offset(1) + c(FLOW_STROKE_MEAN)
        factor(3) = factor(3)*(1 + c(FLOW_DEVIATION))
        if (abs(c(FLOW_PLANE)) > 0) text = text//'eta0 = '//number_text(self%kinematics%eta + c(FLOW_PLANE))//NL
      end if
      factor(pitch) = factor(pitch)*(1 + c(FLOW_PITCH))
      offset(pitch) = offset(pitch) + c(FLOW_PITCH_MEAN)
      lead(pitch) = lead(pitch) + c(FLOW_LEAD)
    end associate
    text = text//'kinematics_factor = '//three(factor)//NL//'kinematics_offset = '//three(offset)//NL// &
           'kinematics_lead = '//three(lead)//NL
    associate (c => request%change([FLOW_DEVIATION_COS, FLOW_DEVIATION_SIN]), given => self%kinematics%deviation)
      if (any(abs(c) > 0)) text = text//'kinematics_deviation = '//number_text(given(1) + c(1))//' '// &
                                  number_text(given(2) + c(2))//NL
    end associate
  end function kinematics_text

  !> Returns E [Pa] and D [N m] of the wings of the case.
  pure function material_of(self) result(material)
    class(flight_case_t), intent(in) :: self
    real(rp) :: material(2)
    material = [self%settings%coupler%model%params%young, self%settings%coupler%model%params%plate]
  end function material_of

  !> Returns lines KEY = VALUE.
  function numbers(keys, values) result(text)
    character(*), intent(in) :: keys(:)
    real(rp), intent(in) :: values(:)
    character(:), allocatable :: text
    integer :: i
    text = ''
    do i = 1, size(keys)
      text = text//trim(keys(i))//' = '//number_text(values(i))//NL
    end do
  end function numbers

  !> Returns the name under which the ini file of a flight is read. No file of that name exists. It is in the folder of the case,
  !> so that relative names of files in the case stay valid.
  function case_name(self) result(name)
    class(flight_case_t), intent(in) :: self
    character(:), allocatable :: name
    name = join_path(folder_of(self%path), 'flight-of-'//name_of(self%path))
  end function case_name

  !> Reads the settings of a flight. Mistakes go to `errors`. Collective if `world` is present.
  subroutine case_read(self, request, settings, errors, world)
    class(flight_case_t), intent(in) :: self
    type(flight_request_t), intent(in) :: request
    type(settings_t), intent(out) :: settings
    type(message_list_t), intent(inout) :: errors
    type(world_t), intent(in), optional :: world
    type(message_list_t) :: notices
    character(:), allocatable :: fault
    fault = omission_fault(self%settings, self%omitted, request%change)
    if (fault /= '') call errors%add(fault)
    call load_settings(self%text(request), self%name(), .false., settings, errors, notices, world)
  end subroutine case_read

  !> Returns a word that identifies the inputs of a flight, the version of the program and its commit. If the inputs are not valid,
  !> `reason` is allocated and says why. Not collective.
  subroutine case_fingerprint(self, request, word, reason)
    class(flight_case_t), intent(in) :: self
    type(flight_request_t), intent(in) :: request
    character(:), allocatable, intent(out) :: word, reason
    type(settings_t), allocatable :: settings
    type(message_list_t) :: errors
    character(16) :: digits
    allocate (settings)
    call self%read(request, settings, errors)
    if (errors%count() > 0) reason = errors%text(1)
    write (digits, '(z16.16)') checksum_text(settings%config%inputs()//BUILD_VERSION//' '//BUILD_COMMIT)
    word = digits
  end subroutine case_fingerprint
end module diagnose_flight_case
