! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the material parameters of a wing, addressed by name. solid_usual_causes describes those of
!> the usual model. The effects that it leaves out follow them: see solid_effects.
!>
!> D = Em h^3/(12 (1 - nu^2)) is a regularisation and was not measured. Without it the tangent of the flat wing is singular, and
!> loaded wings have many wrinkled equilibria.
module solid_params
  use base_cause, only: cause_parameter_t
  use base_errors, only: require
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use base_visitor, only: visited_t, visitor_t
  use solid_effects, only: describe_effect, effects_t, start_effects
  use solid_usual_causes, only: usual_parameter, EACH_JOINT, EACH_VEIN, N_COMMON, PARAM_EXPONENT, PARAM_K_CROSS, &
                                PARAM_K_MEMBRANE, PARAM_K_VEIN, PARAM_PLATE, PARAM_ROOT, PARAM_THICKNESS, PARAM_YOUNG
  use solid_wing, only: wing_t
  implicit none
  private
  public :: solid_params_t, default_params, membrane_thickness, membrane_note

  !> Values of all parameters and the choices of the model.
  type, extends(visited_t) :: solid_params_t
    real(rp) :: young = 12.58e9_rp           !< [Pa] the paper's mean
    real(rp) :: plate = 2.0e-7_rp            !< [N m] D
    real(rp) :: root_factor = 1
    real(rp) :: diameter_exponent = 4
    real(rp) :: k_vein = 1.0e5_rp            !< [N/m]
    real(rp) :: k_membrane = 1.0e5_rp        !< [N/m]
    real(rp) :: k_cross = 1.0e5_rp           !< [N/m]
    real(rp), allocatable :: vein_factor(:)  !< (veins)
    real(rp), allocatable :: joint(:)        !< (joints) [N m/rad]; the stiffness of the vein without the joint unless set
    logical :: cross_springs = .false.       !< springs between the apexes of neighbouring triangles
    real(rp) :: membrane_young = 5.0e9_rp    !< [Pa] for the thickness that corresponds to D
    real(rp) :: membrane_poisson = 0.3_rp
    real(rp) :: slack = 1                    !< tension-field model: stiffness left in compression
    real(rp) :: slack_width = 1.0e-9_rp      !< [m]
    character(:), allocatable :: vein_names(:), joint_names(:)
    type(effects_t) :: effects
    real(rp) :: bending_factor = 1           !< on all bending stiffness, for instance after drying; not a wing parameter
  contains
    procedure :: visit => params_visit
    procedure :: count => params_count
    procedure :: count_basic => params_count_basic
    procedure :: is_joint => params_is_joint
    procedure :: describe => params_describe
    procedure :: find => params_find
    procedure :: get => params_get
    procedure :: set => params_set
    procedure :: set_named => params_set_named
  end type solid_params_t

contains

  !> Shows the usual parameters and the choices of the model to the visitor. Effects have names and numbers of their own.
  subroutine params_visit(self, visitor)
    class(solid_params_t), intent(inout) :: self
    class(visitor_t), intent(inout) :: visitor
    call visitor%visit('young', self%young)
    call visitor%visit('plate', self%plate)
    call visitor%visit('root_factor', self%root_factor)
    call visitor%visit('diameter_exponent', self%diameter_exponent)
    call visitor%visit('k_vein', self%k_vein)
    call visitor%visit('k_membrane', self%k_membrane)
    call visitor%visit('k_cross', self%k_cross)
    call visitor%visit_allocatable('vein_factor', self%vein_factor)
    call visitor%visit_allocatable('joint', self%joint)
    call visitor%visit('cross_springs', self%cross_springs)
    call visitor%visit('membrane_young', self%membrane_young)
    call visitor%visit('membrane_poisson', self%membrane_poisson)
    call visitor%visit('slack', self%slack)
    call visitor%visit('slack_width', self%slack_width)
    call visitor%leave_out('vein_names joint_names effects')
    call visitor%visit('bending_factor', self%bending_factor)
  end subroutine params_visit

  !> Returns the default parameters of a wing. The stiffness of the joints is negative, which means "as the vein".
  function default_params(wing) result(self)
    type(wing_t), intent(in) :: wing
    type(solid_params_t) :: self
    integer :: i, length
    allocate (self%vein_factor(size(wing%veins)), source=1.0_rp)
    allocate (self%joint(size(wing%joints)), source=-1.0_rp)
    call start_effects(size(wing%joints), self%effects)
    length = 1
    do i = 1, size(wing%veins)
      length = max(length, len(wing%veins(i)%name))
    end do
    do i = 1, size(wing%joints)
      length = max(length, len(wing%joints(i)%name))
    end do
    allocate (character(length) :: self%vein_names(size(wing%veins)), self%joint_names(size(wing%joints)))
    do i = 1, size(wing%veins)
      self%vein_names(i) = wing%veins(i)%name
    end do
    do i = 1, size(wing%joints)
      self%joint_names(i) = wing%joints(i)%name
    end do
  end function default_params

  !> Returns the number of parameters, those of effects included.
  pure integer function params_count(self) result(n)
    class(solid_params_t), intent(in) :: self
    n = self%count_basic() + self%effects%count()
  end function params_count

  !> Returns the number of parameters of the usual model. The parameters of effects follow them.
  pure integer function params_count_basic(self) result(n)
    class(solid_params_t), intent(in) :: self
    n = N_COMMON + size(self%vein_factor) + size(self%joint)
  end function params_count_basic

  !> Tells whether parameter i is the stiffness of a joint.
  pure elemental logical function params_is_joint(self, i) result(is_it)
    class(solid_params_t), intent(in) :: self
    integer, intent(in) :: i
    is_it = i > N_COMMON + size(self%vein_factor) .and. i <= self%count_basic()
  end function params_is_joint

  !> Returns name, unit, scale and bounds of parameter i. The order is: the eight common ones, the veins, the joints, the effects.
  function params_describe(self, i) result(p)
    class(solid_params_t), intent(in) :: self
    integer, intent(in) :: i
    type(parameter_t) :: p
    integer :: n_veins
    n_veins = size(self%vein_factor)
    call require(i >= 1 .and. i <= self%count(), 'solid_params_t: no such parameter')
    select case (i)
    case (:N_COMMON)
      p = usual(i)
    case default
      if (i > self%count_basic()) then
        p = describe_effect(i - self%count_basic(), self%joint_names)
      else if (i <= N_COMMON + n_veins) then
        p = usual(EACH_VEIN)
        p%name = p%name//trim(self%vein_names(i - N_COMMON))
      else
        p = usual(EACH_JOINT)
        p%name = p%name//trim(self%joint_names(i - N_COMMON - n_veins))
      end if
    end select

  contains

    !> Returns a parameter of the usual model.
    pure function usual(number) result(value)
      integer, intent(in) :: number
      type(parameter_t) :: value
      type(cause_parameter_t) :: one
      one = usual_parameter(number)
      value = one%value
    end function usual

  end function params_describe

  !> Returns the number of the parameter called `name`, 0 if there is none.
  integer function params_find(self, name) result(found)
    class(solid_params_t), intent(in) :: self
    character(*), intent(in) :: name
    type(parameter_t) :: p
    integer :: i
    found = 0
    do i = 1, self%count()
      p = self%describe(i)
      if (p%name == name) found = i
    end do
  end function params_find

  !> Sets the parameter called `name`, in its unit. A name that the wing does not have stops the program.
  subroutine params_set_named(self, name, value)
    class(solid_params_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(in) :: value
    integer :: i
    i = self%find(name)
    call require(i > 0, 'solid_params_t: no parameter '//name)
    call self%set(i, value)
  end subroutine params_set_named

  !> Returns the value of parameter i, in its unit.
  pure real(rp) function params_get(self, i) result(value)
    class(solid_params_t), intent(in) :: self
    integer, intent(in) :: i
    select case (i)
    case (PARAM_YOUNG)
      value = self%young
    case (PARAM_PLATE)
      value = self%plate
    case (PARAM_THICKNESS)
      value = membrane_thickness(self, self%plate)
    case (PARAM_ROOT)
      value = self%root_factor
    case (PARAM_EXPONENT)
      value = self%diameter_exponent
    case (PARAM_K_VEIN)
      value = self%k_vein
    case (PARAM_K_MEMBRANE)
      value = self%k_membrane
    case (PARAM_K_CROSS)
      value = self%k_cross
    case default
      if (i > self%count_basic()) then
        value = self%effects%get(i - self%count_basic())
      else if (i <= N_COMMON + size(self%vein_factor)) then
        value = self%vein_factor(i - N_COMMON)
      else
        value = self%joint(i - N_COMMON - size(self%vein_factor))
      end if
    end select
  end function params_get

  !> Sets parameter i, in its unit. D and `thickness` are two names of the same parameter. A model does not change by itself: see
  !> solid_model_t%set_params.
  pure subroutine params_set(self, i, value)
    class(solid_params_t), intent(inout) :: self
    integer, intent(in) :: i
    real(rp), intent(in) :: value
    select case (i)
    case (PARAM_YOUNG)
      self%young = value
    case (PARAM_PLATE)
      self%plate = value
    case (PARAM_THICKNESS)
      self%plate = membrane_bending(self, value)
    case (PARAM_ROOT)
      self%root_factor = value
    case (PARAM_EXPONENT)
      self%diameter_exponent = value
    case (PARAM_K_VEIN)
      self%k_vein = value
    case (PARAM_K_MEMBRANE)
      self%k_membrane = value
    case (PARAM_K_CROSS)
      self%k_cross = value
    case default
      if (i > self%count_basic()) then
        call self%effects%set(i - self%count_basic(), value)
      else if (i <= N_COMMON + size(self%vein_factor)) then
        self%vein_factor(i - N_COMMON) = value
      else
        self%joint(i - N_COMMON - size(self%vein_factor)) = value
      end if
    end select
  end subroutine params_set

  !> Returns the thickness [m] of a plate of the membrane's material with bending stiffness `plate` [N m].
  pure real(rp) function membrane_thickness(self, plate) result(h)
    class(solid_params_t), intent(in) :: self
    real(rp), intent(in) :: plate
    h = (12*(1 - self%membrane_poisson**2)*plate/self%membrane_young)**(1.0_rp/3)
  end function membrane_thickness

  !> Returns the bending stiffness [N m] of a plate of the membrane's material with thickness h [m].
  pure real(rp) function membrane_bending(self, h) result(plate)
    class(solid_params_t), intent(in) :: self
    real(rp), intent(in) :: h
    plate = self%membrane_young*h**3/(12*(1 - self%membrane_poisson**2))
  end function membrane_bending

  !> Returns a sentence about D for the start of a run: the corresponding thickness, and a warning if D is so small that
  !> equilibria are not unique (`is_soft`).
  subroutine membrane_note(self, note, is_soft)
    class(solid_params_t), intent(in) :: self
    character(:), allocatable, intent(out) :: note
    logical, intent(out) :: is_soft
    real(rp), parameter :: UNIQUE_ABOVE = 1.999e-7_rp ! [N m], the default; by measurement: bench/static/run --table
    character(160) :: text
    write (text, '(a,es9.2,a,f6.2,a,f6.2,a)') 'membrane bending stiffness D = ', self%plate, &
      ' N m, which means ', membrane_thickness(self, self%plate)*1.0e6_rp, ' um at ', &
      self%membrane_young*1.0e-9_rp, ' GPa; a regularising parameter, not measured'
    note = trim(text)
    is_soft = self%plate < UNIQUE_ABOVE
    if (is_soft) note = note//'; below the default of 2E-7 N m the wing has many wrinkled equilibria, and shapes depend on '// &
      'the loading path'
  end subroutine membrane_note
end module solid_params
