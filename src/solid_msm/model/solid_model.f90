! SPDX-License-Identifier: GPL-3.0-or-later
!> Builds the mechanical model of a wing: its elements, their stiffness, and the energy and its gradient as functions of the
!> displacements.
!>
!> Displacements and forces are arrays (3, n_all) over the wing's points and the clamped ghost points
!> behind them; displacements of clamped points are zero.
module solid_model
  use base_errors, only: failure_t, require
  use base_kinds, only: rp
  use base_text, only: number_text
  use solid_arch, only: arch_energy, arch_gradient
  use solid_edges, only: edges_t, make_edges
  use solid_effect, only: NEED_NO_SLACK, NEED_SIDED_JOINTS, NEED_SIDED_VEINS
  use solid_effects, only: active_needs, modulus_factors
  use solid_elements, only: make_springs, make_hinges, make_plate, link_elements, point_weights
  use solid_extension, only: extensions_t, extension_energy, extension_gradient, tension_energy, tension_gradient
  use solid_flatness, only: find_flatness
  use solid_hinge, only: hinge_t, hinge_evaluate, HINGE_NODES
  use solid_junctions, only: hinge_plan_t, plan_hinges
  use solid_layout, only: hinge_in_vein, layout_t, make_layout
  use solid_params, only: solid_params_t
  use solid_pattern, only: pattern_t
  use solid_plate, only: edges_energy, plate_t, plate_energy, plate_gradient
  use solid_stiffness, only: stiffness_t, allocate_stiffness, evaluate_stiffness, differentiate_basic, &
                             bending_stiffness
  use solid_twist, only: camber_evaluate, make_twists, twist_evaluate, twist_t
  use solid_wing, only: wing_t
  implicit none
  private
  public :: solid_model_t

  !> All constant data of a wing. They do not change during a computation.
  type :: solid_model_t
    integer :: n_points = 0                 !< of the wing
    integer :: n_all = 0                    !< with the ghost points
    integer :: n_free = 0                   !< points that can move
    real(rp), allocatable :: points(:, :)   !< (3, n_all) [m] stress-free positions
    integer, allocatable :: triangles(:, :) !< (3, m)
    integer, allocatable :: free(:)         !< (n_all) number among the free points, 0: clamped
    integer, allocatable :: movable(:)      !< (n_free) the free points
    real(rp), allocatable :: weights(:)     !< (n_free) share of the surface (or of the length), mean 1
    real(rp) :: size = 0                    !< [m] largest distance of a point from the root's centre
    type(layout_t) :: layout                !< where the elements lie
    type(solid_params_t) :: params
    type(extensions_t) :: springs
    type(hinge_t), allocatable :: hinges(:)
    type(twist_t), allocatable :: twists(:)       !< (hinges)
    type(hinge_plan_t), allocatable :: plans(:)   !< properties of the hinges
    type(stiffness_t) :: stiffness
    type(pattern_t) :: pattern
    type(plate_t) :: plate
  contains
    procedure :: init => model_init
    procedure :: set_params => model_set_params
    procedure :: stiffness_derivative => model_stiffness_derivative
    procedure :: energy => model_energy
    procedure :: gradient => model_gradient
    procedure :: zero_clamped => model_zero_clamped
  end type solid_model_t

contains

  !> Builds the model of a wing. Fails when the reference is not flat, when nothing is clamped, when a joint fits no two vein
  !> segments, when there is no hinge for the effect `soft`, or when the requirements of an effect are not met. Negative stiffnesses
  !> of joints are replaced by those of the veins.
  subroutine model_init(self, wing, params, failure)
    class(solid_model_t), intent(out) :: self
    type(wing_t), intent(in) :: wing
    type(solid_params_t), intent(in) :: params
    type(failure_t), intent(out) :: failure
    type(edges_t) :: edges
    real(rp), allocatable :: ghosts(:, :), modulus(:)
    real(rp) :: normal(3)
    integer :: stray, raised, bent, i, n_twists

    self%params = params
    self%n_points = size(wing%points, 2)
    self%triangles = wing%triangles
    if (size(wing%root) == 0) then
      call failure%raise('the wing has no clamped points: name some in /root of the wing file')
      return
    end if
    call plan_hinges(wing, self%plans, ghosts, stray)
    if (stray > 0) then
      call failure%raise("joint '"//wing%joints(stray)%name// &
                         "' fits no two vein segments that meet in one point")
      return
    end if
    call find_flatness(wing, self%plans, normal, raised, bent) ! the reader of wing files refuses both
    if (raised > 0) then
      call failure%raise('the unloaded membrane must be flat, point '//number_text(raised)//' is not in its plane')
    else if (bent > 0) then
      call failure%raise('the veins at point '//number_text(bent)//' bend out of the plane of the wing; '// &
                         'move the point into the plane')
    end if
    if (failure%failed) return
    call number_points(self, wing, ghosts)
    self%layout%mean_diameter = mean_diameter(wing)
    edges = make_edges(self%n_points, wing%triangles)
    call make_springs(wing, edges, params, self%points, self%springs)
    call make_hinges(wing, edges, self%plans, self%points, normal, params%effects%has_sides, self%hinges)
    self%plate = make_plate(edges, self%points)
    call make_twists(edges, self%plans, wing%triangles, self%points, self%twists)
    n_twists = 0
    if (params%effects%has_sided_veins) n_twists = size(self%twists)
    call link_elements(self%free, self%n_free, self%springs, self%hinges, self%plate, &
                       self%twists(:n_twists), self%pattern)
    self%weights = point_weights(wing, self%movable)
    call make_layout(self%points, wing, self%springs, self%plans, self%plate, self%layout)
    call place_soft_hinge(self, wing, failure)
    call check_needs(params, failure)
    if (failure%failed) return
    call allocate_stiffness(self%springs, self%plans, self%plate%n, self%stiffness)
    modulus = modulus_factors(self%params%effects, self%plans)
    do i = 1, size(self%plans)
      associate (joint => self%plans(i)%joint)
        if (joint == 0) cycle
        if (self%params%joint(joint) < 0) &
          self%params%joint(joint) = bending_stiffness(self%params, self%plans(i), self%layout%mean_diameter, modulus(i))
      end associate
    end do
    call self%set_params(self%params)
  end subroutine model_init

  !> Sets the points with the ghost points after them, the numbers of the movable ones, and the size of the wing.
  subroutine number_points(self, wing, ghosts)
    class(solid_model_t), intent(inout) :: self
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: ghosts(:, :)
    real(rp) :: centre(3)
    integer :: i
    self%n_all = self%n_points + size(ghosts, 2)
    allocate (self%points(3, self%n_all))
    self%points(:, :self%n_points) = wing%points
    self%points(:, self%n_points + 1:) = ghosts
    allocate (self%free(self%n_all), source=0)
    self%free(:self%n_points) = 1
    self%free(wing%root) = 0
    self%movable = pack([(i, i=1, self%n_all)], self%free > 0)
    self%n_free = size(self%movable)
    self%free(self%movable) = [(i, i=1, self%n_free)]
    centre = sum(wing%points(:, wing%root), 2)/size(wing%root)
    do i = 1, self%n_points
      self%size = max(self%size, norm2(wing%points(:, i) - centre))
    end do
  end subroutine number_points

  !> Returns the mean diameter [m] over all points of all veins.
  pure real(rp) function mean_diameter(wing)
    type(wing_t), intent(in) :: wing
    integer :: i, n
    mean_diameter = 0
    n = 0
    do i = 1, size(wing%veins)
      mean_diameter = mean_diameter + sum(wing%veins(i)%diameters)
      n = n + size(wing%veins(i)%diameters)
    end do
    mean_diameter = mean_diameter/max(1, n)
  end function mean_diameter

  !> Checks that the requirements of all active effects are met.
  subroutine check_needs(params, failure)
    type(solid_params_t), intent(in) :: params
    type(failure_t), intent(inout) :: failure
    integer, allocatable :: needs(:)
    needs = active_needs(params%effects)
    if (any(needs == NEED_SIDED_JOINTS) .and. .not. params%effects%has_sides) &
      call failure%raise('one-way joints need [Wing] sided_joints = yes')
    if (any(needs == NEED_SIDED_VEINS) .and. .not. params%effects%has_sided_veins) &
      call failure%raise('torsion and camber of veins need [Wing] sided_veins = yes')
    if (any(needs == NEED_NO_SLACK) .and. params%slack < 1) &
      call failure%raise('a membrane that goes slack under compression ([Wing] slack below 1) cannot have a pretension')
  end subroutine check_needs

  !> Finds the hinge of the soft place, if there is one. Fails if no hinge is there.
  subroutine place_soft_hinge(self, wing, failure)
    class(solid_model_t), intent(inout) :: self
    type(wing_t), intent(in) :: wing
    type(failure_t), intent(inout) :: failure
    integer :: v
    if (.not. allocated(self%params%effects%soft_vein)) return
    associate (name => self%params%effects%soft_vein)
      do v = 1, size(wing%veins)
        if (wing%veins(v)%name /= name) cycle
        self%layout%soft_hinge = hinge_in_vein(wing, self%plans, v, self%params%effects%soft_fraction)
        if (self%layout%soft_hinge == 0) &
          call failure%raise("the soft place in vein '"//name//"' is at no free point: the vein has no free point inside, or "// &
                             'a joint is there')
        return
      end do
      call failure%raise("there is no vein '"//name//"' for the soft place")
    end associate
  end subroutine place_soft_hinge

  !> Takes over new values of the parameters. The choices of cross-springs and of the soft hinge stay those of `init`.
  subroutine model_set_params(self, params)
    class(solid_model_t), intent(inout) :: self
    type(solid_params_t), intent(in) :: params
    self%params = params
    self%springs%slack = params%slack
    self%springs%width = params%slack_width
    call evaluate_stiffness(params, self%springs, self%plans, self%layout, self%stiffness)
    self%springs%tension = self%stiffness%tension
  end subroutine model_set_params

  !> Returns the derivative of all stiffnesses with respect to a parameter of the usual model, per unit or, with `per_log`, per
  !> log unit. Given to `gradient`, it yields the derivative of the gradient. For effects see solid_stiffness_effects.
  subroutine model_stiffness_derivative(self, number, per_log, derivative)
    class(solid_model_t), intent(in) :: self
    integer, intent(in) :: number
    logical, intent(in) :: per_log
    type(stiffness_t), intent(inout) :: derivative
    call require(number <= self%params%count_basic(), 'solid_model_t: no parameter of the usual model')
    if (.not. allocated(derivative%hinge)) &
      call allocate_stiffness(self%springs, self%plans, self%plate%n, derivative)
    call differentiate_basic(self%params, self%springs, self%plans, self%layout, number, per_log, derivative)
  end subroutine model_stiffness_derivative

  !> Returns the elastic energy [J] at displacements u(3, n_all) [m]; its parts are those of extension, hinges and plate.
  real(rp) function model_energy(self, u, parts) result(energy)
    class(solid_model_t), intent(in) :: self
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(out), optional :: parts(3)
    real(rp) :: e(3), one, local(3, HINGE_NODES)
    integer :: h, i
    e(1) = extension_energy(self%springs, self%stiffness%extension, u)
    if (self%stiffness%has_tension) e(1) = e(1) + tension_energy(self%springs, self%stiffness%tension, u)
    e(2) = 0
    local = 0
    do h = 1, size(self%hinges)
      do i = 1, self%hinges(h)%n_nodes
        local(:, i) = u(:, self%hinges(h)%nodes(i))
      end do
      call hinge_evaluate(self%hinges(h), self%stiffness%hinge(h), local, one, cubic=self%stiffness%cubic(h), &
                          lift=self%stiffness%lift(h))
      e(2) = e(2) + one
      if (.not. abs(self%stiffness%twist(h)) + abs(self%stiffness%camber_moment(h)) > 0) cycle
      do i = 1, self%twists(h)%n_nodes
        local(:, i) = u(:, self%twists(h)%nodes(i))
      end do
      if (self%twists(h)%is_twistable) then
        call twist_evaluate(self%twists(h), self%stiffness%twist(h), local, one)
        e(2) = e(2) + one
      end if
      if (self%twists(h)%n_nodes == 0) cycle
      call camber_evaluate(self%twists(h), self%stiffness%camber_moment(h), local, one)
      e(2) = e(2) + one
    end do
    e(3) = self%stiffness%plate*plate_energy(self%plate, u)
    if (self%stiffness%has_edges) e(3) = e(3) + edges_energy(self%plate, self%stiffness%edge, u)
    if (self%stiffness%has_arch) e(3) = e(3) + arch_energy(self%plate, self%points, self%stiffness%arch, u)
    energy = sum(e)
    if (present(parts)) parts = e
  end function model_energy

  !> Sets g(3, n_all) [N] to the gradient of the energy at u(3, n_all) [m], with the stiffness of the model or with another one (or
  !> its derivative). `low` is a part of the displacement below the rounding of u; it enters only the springs.
  subroutine model_gradient(self, u, g, stiffness, low)
    class(solid_model_t), intent(in) :: self
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(out) :: g(:, :)
    type(stiffness_t), intent(in), optional :: stiffness
    real(rp), intent(in), optional :: low(:, :)
    g = 0
    ! An absent array must not be passed on, because its bounds would be evaluated.
    if (present(stiffness) .and. present(low)) then
      call extension_gradient(self%springs, stiffness%extension, u, g, low)
    else if (present(stiffness)) then
      call extension_gradient(self%springs, stiffness%extension, u, g)
    else if (present(low)) then
      call extension_gradient(self%springs, self%stiffness%extension, u, g, low)
    else
      call extension_gradient(self%springs, self%stiffness%extension, u, g)
    end if
    if (present(stiffness)) then
      call add_bending(self, stiffness, u, g)
    else
      call add_bending(self, self%stiffness, u, g)
    end if
  end subroutine model_gradient

  !> Adds the gradient of the bending energy of hinges and membrane.
  subroutine add_bending(self, stiffness, u, g)
    class(solid_model_t), intent(in) :: self
    type(stiffness_t), intent(in) :: stiffness
    real(rp), intent(in) :: u(:, :)
    real(rp), intent(inout) :: g(:, :)
    real(rp) :: energy, local(3, HINGE_NODES), pull(3, HINGE_NODES), bent(3, HINGE_NODES)
    integer :: h, i, p
    local = 0
    do h = 1, size(self%hinges)
      if (.not. abs(stiffness%hinge(h)) + abs(stiffness%cubic(h)) + abs(stiffness%lift(h)) > 0) cycle
      do i = 1, self%hinges(h)%n_nodes
        local(:, i) = u(:, self%hinges(h)%nodes(i))
      end do
      call hinge_evaluate(self%hinges(h), stiffness%hinge(h), local, energy, pull, cubic=stiffness%cubic(h), &
                          lift=stiffness%lift(h))
      do i = 1, self%hinges(h)%n_nodes
        p = self%hinges(h)%nodes(i)
        g(:, p) = g(:, p) + pull(:, i)
      end do
    end do
    if (abs(stiffness%plate) > 0 .or. stiffness%has_edges) &
      call plate_gradient(self%plate, stiffness%plate, stiffness%edge, u, g)
    if (stiffness%has_arch) call arch_gradient(self%plate, self%points, stiffness%arch, u, g)
    if (stiffness%has_tension) call tension_gradient(self%springs, stiffness%tension, u, g)
    if (.not. (stiffness%has_twist .or. stiffness%has_arch)) return
    do h = 1, size(self%twists)
      if (.not. abs(stiffness%twist(h)) + abs(stiffness%camber_moment(h)) > 0 .or. self%twists(h)%n_nodes == 0) cycle
      do i = 1, self%twists(h)%n_nodes
        local(:, i) = u(:, self%twists(h)%nodes(i))
      end do
      call camber_evaluate(self%twists(h), stiffness%camber_moment(h), local, energy, bent)
      pull = 0
      if (self%twists(h)%is_twistable) call twist_evaluate(self%twists(h), stiffness%twist(h), local, energy, pull)
      do i = 1, self%twists(h)%n_nodes
        p = self%twists(h)%nodes(i)
        g(:, p) = g(:, p) + pull(:, i) + bent(:, i)
      end do
    end do
  end subroutine add_bending

  !> Sets the columns of clamped points of a(3, n_all) to zero.
  pure subroutine model_zero_clamped(self, a)
    class(solid_model_t), intent(in) :: self
    real(rp), intent(inout) :: a(:, :)
    integer :: i
    do i = 1, self%n_all
      if (self%free(i) == 0) a(:, i) = 0
    end do
  end subroutine model_zero_clamped
end module solid_model
