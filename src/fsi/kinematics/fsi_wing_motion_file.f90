! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads FLUSI's kinematics files: [kinematics] with Fourier or Hermite coefficients of the three angles
!> of a wing (see `fsi_wing_motion_series`), one cycle of period 1.
!>
!> convention = flusi: all angles right-handed, theta > 0 is down; SISC: theta > 0 is up. Files without a section are read in the
!> format from before 2015 (fsi_wing_motion_list).
module fsi_wing_motion_file
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_text, only: number_text, to_lower
  use fsi_wing_motion, only: wing_motion_t
  use fsi_wing_motion_list, only: read_motion_list
  use fsi_wing_motion_series, only: angle_series_t
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  implicit none
  private
  public :: read_motion_file

  character(*), parameter :: SECTION = 'kinematics'
  character(*), parameter :: TYPES = 'fourier|hermite|Fourier|Hermite|FOURIER|HERMITE'
  character(*), parameter :: UNITS = 'degree|radian|degrees|radians|radiant|DEGREE|RADIAN|RADIANT'
  character(*), parameter :: CONVENTIONS = 'flusi|SISC|FLUSI|sisc|siam-sisc'
  integer, parameter :: MOST_COEFFICIENTS = 100000
  character(5), parameter :: ANGLES(3) = ['phi  ', 'alpha', 'theta']

  !> Coefficients of one angle.
  type :: angle_choices_t
    integer :: n = 0
    logical :: has_n = .false.
    real(rp) :: a0 = 0
    real(rp), allocatable :: a(:), b(:)
  end type angle_choices_t

  !> The contents of a file.
  type :: motion_choices_t
    character(:), allocatable :: type, units, convention
    type(angle_choices_t) :: angles(3) !< phi, alpha, theta
  end type motion_choices_t

contains

  !> Declares and reads the keys of a kinematics file.
  subroutine motion_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(motion_choices_t), intent(inout) :: c
    character(*), parameter :: NAMES(3) = ['position  ', 'feathering', 'deviation ']
    integer :: i
    call keys%section(SECTION, 'motion of one wing over one cycle')
    call keys%inert('format', 'version of the format; there is one')
    call keys%word('type', c%type, 'fourier', TYPES, 'fourier: a0/2 + sum ai cos(2 pi i t) + bi sin(2 pi i t); hermite: ai = '// &
                   'values, bi = slopes at (i-1)/nfft', required=.true.)
    call keys%word('units', c%units, 'degree', UNITS, 'of all angles; time is in cycles')
    call keys%word('convention', c%convention, 'flusi', CONVENTIONS, 'flusi: deviation theta positive downwards; SISC: '// &
                   'positive upwards')
    do i = 1, 3
      call angle_keys(keys, trim(ANGLES(i)), trim(NAMES(i)), c%angles(i))
    end do
  end subroutine motion_keys

  !> Visits the keys of one angle.
  subroutine angle_keys(keys, angle, name, c)
    type(keys_t), intent(in) :: keys
    character(*), intent(in) :: angle, name
    type(angle_choices_t), intent(inout) :: c
    real(rp), parameter :: NOTHING(0) = [real(rp) ::]
    call keys%integer('nfft_'//angle, c%n, 0, 'number of coefficients of the '//name//' angle', min=0, max=MOST_COEFFICIENTS, &
                      required=.true., given=c%has_n)
    call keys%real('a0_'//angle, c%a0, 0.0_rp, 'twice the mean of the '//name//' angle, fourier only', unit='units')
    call keys%list('ai_'//angle, c%a, NOTHING, 'cosine coefficients or values', unit='units')
    call keys%list('bi_'//angle, c%b, NOTHING, 'sine coefficients or slopes', unit='units or units/cycle')
  end subroutine angle_keys

  !> Fills the three series of `motion` from `text`, the content of the file called `name`. Every mistake is added to `errors` with
  !> its line; angles with mistakes then keep their values.
  subroutine read_motion_file(text, name, motion, errors, notices)
    character(*), intent(in) :: text, name
    type(wing_motion_t), intent(inout) :: motion
    type(message_list_t), intent(inout) :: errors, notices
    type(registry_t), target :: registry
    type(config_t), target :: config
    type(message_list_t) :: mistakes
    type(motion_choices_t) :: c
    type(keys_t) :: keys
    logical :: is_hermite
    real(rp) :: unit, upward
    integer :: i
    if (index(text, '['//SECTION//']') == 0 .and. index(text, '=') == 0) then
      call read_motion_list(text, name, motion, errors)
      return
    end if
    keys = declaring(registry)
    call motion_keys(keys, c)
    call config%load_text(text, name, registry, mistakes, notices)
    keys = reading(config)
    call motion_keys(keys, c)
    is_hermite = to_lower(c%type) == 'hermite'
    unit = 1
    if (index(to_lower(c%units), 'degree') > 0) unit = PI/180
    upward = 1
    if (index(to_lower(c%convention), 'sisc') > 0) upward = -1
    call set_angle(config, 1, is_hermite, unit, c%angles(1), motion%phi, mistakes, notices)
    call set_angle(config, 2, is_hermite, unit, c%angles(2), motion%alpha, mistakes, notices)
    call set_angle(config, 3, is_hermite, upward*unit, c%angles(3), motion%theta, mistakes, notices)
    do i = 1, mistakes%count()
      call errors%add(mistakes%text(i))
    end do
  end subroutine read_motion_file

  !> Sets the series of one angle from its keys, or reports their mistakes.
  subroutine set_angle(config, number, is_hermite, unit, c, series, errors, notices)
    type(config_t), intent(in) :: config
    integer, intent(in) :: number
    logical, intent(in) :: is_hermite
    real(rp), intent(in) :: unit
    type(angle_choices_t), intent(inout) :: c
    type(angle_series_t), intent(inout) :: series
    type(message_list_t), intent(inout) :: errors, notices
    character(:), allocatable :: angle
    if (.not. c%has_n) return ! missing or wrong, which is reported
    angle = trim(ANGLES(number))
    call check_coefficients(config, 'ai_'//angle, c%n, c%a, errors)
    call check_coefficients(config, 'bi_'//angle, c%n, c%b, errors)
    associate (n => c%n, a0 => c%a0, a => c%a, b => c%b)
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
    end associate
  end subroutine set_angle

  !> Checks that a list has n numbers; adds an error if it has not.
  subroutine check_coefficients(config, key, n, x, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: key
    integer, intent(in) :: n
    real(rp), allocatable, intent(inout) :: x(:)
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: angle
    if (n == 0 .and. all(abs(x) <= 0)) x = x(:0) ! FLUSI's files have one zero if nfft = 0
    if (size(x) == n) return
    angle = key(index(key, '_') + 1:)
    if (size(x) == 0) then
      call config%complain(errors, SECTION, key, 'is missing; nfft_'//angle//' asks for '//reals(n))
    else if (n == 0) then
      call config%complain(errors, SECTION, key, 'has '//reals(size(x))//', but nfft_'//angle//' is 0')
    else
      call config%complain(errors, SECTION, key, 'has '//reals(size(x))//', but nfft_'//angle//' asks for '//reals(n))
    end if
  end subroutine check_coefficients

  !> Returns a count, as in "3 numbers".
  function reals(n) result(text)
    integer, intent(in) :: n
    character(:), allocatable :: text
    text = number_text(n)//trim(merge(' number ', ' numbers', n == 1))
  end function reals
end module fsi_wing_motion_file
