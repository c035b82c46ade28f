! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads FLUSI's kinematics files: [kinematics] with Fourier or Hermite coefficients of the three angles
!> of a wing (see `fsi_wing_motion_series`), one cycle of period 1.
!>
!> convention = flusi: all angles right-handed, theta > 0 is down; SISC: theta > 0 is up. Files without a section are read as
!> those of before 2015 (fsi_wing_motion_list).
module fsi_wing_motion_file
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text, to_lower
  use fsi_wing_motion, only: wing_motion_t
  use fsi_wing_motion_list, only: read_motion_list
  use fsi_wing_motion_series, only: angle_series_t
  use io_config, only: config_t
  use io_registry, only: registry_t
  implicit none
  private
  public :: read_motion_file, register_motion_keys

  character(*), parameter :: SECTION = 'kinematics'
  character(*), parameter :: TYPES = 'fourier|hermite|Fourier|Hermite|FOURIER|HERMITE'
  character(*), parameter :: UNITS = 'degree|radian|degrees|radians|radiant|DEGREE|RADIAN|RADIANT'
  character(*), parameter :: CONVENTIONS = 'flusi|SISC|FLUSI|sisc|siam-sisc'
  integer, parameter :: MOST_COEFFICIENTS = 100000

contains

  !> Adds the keys of a kinematics file to `registry`, which is one of its own.
  subroutine register_motion_keys(registry)
    type(registry_t), intent(inout) :: registry
    character(5), parameter :: ANGLES(3) = ['phi  ', 'alpha', 'theta']
    character(*), parameter :: NAMES(3) = ['position  ', 'feathering', 'deviation ']
    integer :: i
    call registry%add_section(SECTION, 'motion of one wing over one cycle')
    call registry%add_inert(SECTION, 'format', 'version of the format; there is one')
    call registry%add_word(SECTION, 'type', 'fourier', TYPES, &
           'fourier: a0/2 + sum ai cos(2 pi i t) + bi sin(2 pi i t); hermite: ai = values, bi = slopes at (i-1)/nfft', &
                           required=.true.)
    call registry%add_word(SECTION, 'units', 'degree', UNITS, 'of all angles; time is in cycles')
    call registry%add_word(SECTION, 'convention', 'flusi', CONVENTIONS, &
                           'flusi: deviation theta positive downwards; SISC: positive upwards')
    do i = 1, 3
      call register_angle(registry, trim(ANGLES(i)), trim(NAMES(i)))
    end do
  end subroutine register_motion_keys

  subroutine register_angle(registry, angle, name)
    type(registry_t), intent(inout) :: registry
    character(*), intent(in) :: angle, name
    real(rp), parameter :: NOTHING(0) = [real(rp) ::]
    call registry%add_integer(SECTION, 'nfft_'//angle, 0, 'number of coefficients of the '//name//' angle', min=0, &
                              max=MOST_COEFFICIENTS, required=.true.)
    call registry%add_real(SECTION, 'a0_'//angle, 0.0_rp, 'twice the mean of the '//name//' angle, fourier only', &
                           unit='units')
    call registry%add_reals(SECTION, 'ai_'//angle, NOTHING, 'cosine coefficients or values', unit='units')
    call registry%add_reals(SECTION, 'bi_'//angle, NOTHING, 'sine coefficients or slopes', &
                            unit='units or units/cycle')
  end subroutine register_angle

  !> Fills the three series of `motion` from `text`, the content of the file called `name`. Every mistake is
  !> added to `errors` with its line; then the angles with mistakes keep what they had.
  subroutine read_motion_file(text, name, motion, errors, notices)
    character(*), intent(in) :: text, name
    type(wing_motion_t), intent(inout) :: motion
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t) :: registry
    type(config_t) :: config
    type(message_list_t) :: mistakes
    real(rp) :: unit, upward
    integer :: i
    if (index(text, '['//SECTION//']') == 0 .and. index(text, '=') == 0) then
      call read_motion_list(text, name, motion, errors)
      return
    end if
    call register_motion_keys(registry)
    call config%load_text(text, name, registry, mistakes, notices)
    unit = 1
    if (index(to_lower(config%get_word(SECTION, 'units')), 'degree') > 0) unit = PI/180
    upward = 1
    if (index(to_lower(config%get_word(SECTION, 'convention')), 'sisc') > 0) upward = -1
    call read_angle(config, 'phi', unit, motion%phi, mistakes, notices)
    call read_angle(config, 'alpha', unit, motion%alpha, mistakes, notices)
    call read_angle(config, 'theta', upward*unit, motion%theta, mistakes, notices)
    do i = 1, mistakes%count()
      call errors%add(mistakes%text(i))
    end do
  end subroutine read_motion_file

  subroutine read_angle(config, angle, unit, series, errors, notices)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: angle
    real(rp), intent(in) :: unit
    type(angle_series_t), intent(inout) :: series
    type(message_list_t), intent(inout) :: errors, notices
    real(rp), allocatable :: a(:), b(:)
    real(rp) :: a0
    integer :: n
    logical :: is_hermite
    if (.not. config%is_given(SECTION, 'nfft_'//angle)) return ! missing or wrong, which is reported
    is_hermite = to_lower(config%get_word(SECTION, 'type')) == 'hermite'
    n = config%get_integer(SECTION, 'nfft_'//angle)
    a0 = config%get_real(SECTION, 'a0_'//angle)
    call read_coefficients(config, 'ai_'//angle, n, a, errors)
    call read_coefficients(config, 'bi_'//angle, n, b, errors)
    if (is_hermite) then
      if (n == 0) call config%complain(errors, SECTION, 'nfft_'//angle, &
                                       'is 0, but hermite needs a value; valid: integer >= 1')
      if (abs(a0) > 0) call config%complain(notices, SECTION, 'a0_'//angle, &
                                            'has no effect with type=hermite, as in FLUSI')
    end if
    if (size(a) /= n .or. size(b) /= n .or. (is_hermite .and. n == 0)) return
    if (is_hermite) then
      call series%set_hermite(unit*a, unit*b)
    else if (n == 0) then
      call series%set_constant(unit*a0/2)
    else
      call series%set_fourier(unit*a0, unit*a, unit*b)
    end if
  end subroutine read_angle

  !> n numbers, or a mistake.
  subroutine read_coefficients(config, key, n, x, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: key
    integer, intent(in) :: n
    real(rp), allocatable, intent(out) :: x(:)
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: angle
    x = config%get_reals(SECTION, key)
    if (n == 0 .and. all(abs(x) <= 0)) x = x(:0) ! FLUSI's files write a zero beside nfft = 0
    if (size(x) == n) return
    angle = key(index(key, '_') + 1:)
    if (size(x) == 0) then
      call config%complain(errors, SECTION, key, 'is missing; nfft_'//angle//' asks for '//reals(n))
    else if (n == 0) then
      call config%complain(errors, SECTION, key, 'has '//reals(size(x))//', but nfft_'//angle//' is 0')
    else
      call config%complain(errors, SECTION, key, 'has '//reals(size(x))//', but nfft_'//angle//' asks for '//reals(n))
    end if
  end subroutine read_coefficients

  function reals(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text
    text = number_text(n)//trim(merge(' number ', ' numbers', n == 1))
  end function reals
end module fsi_wing_motion_file
