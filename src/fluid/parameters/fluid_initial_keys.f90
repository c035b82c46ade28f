! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the flow at t = 0 from the keys of [InitialCondition].
module fluid_initial_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use fluid_substitutes, only: FOR_FLOWS, NO_FLOWS
  use io_config, only: config_t
  use io_keys, only: keys_t
  implicit none
  private
  public :: initial_params_t, initial_keys, check_initial, FLOW_QUIESCENT, FLOW_MEAN, FLOW_RING, FLOW_TAYLOR_GREEN_2D, &
            FLOW_TAYLOR_GREEN, FLOW_ROGALLO, FLOW_SPECTRUM, FLOW_FILES, FLOW_BACKUP, FLOW_BACKUP_FILE

  character(*), parameter :: SECTION = 'InitialCondition', AXES = 'xyz', BACKUP_WORD = 'backup::'

  integer, parameter :: FLOW_QUIESCENT = 1, FLOW_MEAN = 2, FLOW_RING = 3, FLOW_TAYLOR_GREEN_2D = 4, FLOW_TAYLOR_GREEN = 5, &
                        FLOW_ROGALLO = 6, FLOW_SPECTRUM = 7, FLOW_FILES = 8
  integer, parameter :: FLOW_BACKUP = 9, FLOW_BACKUP_FILE = 10 !< from the newest checkpoint, from a named checkpoint
  type(named_kind_t), parameter :: FLOWS(10) = [ &
    named_kind_t('quiescent', FLOW_QUIESCENT), named_kind_t('MeanFlow', FLOW_MEAN), named_kind_t('VortexRing', FLOW_RING), &
    named_kind_t('taylor_green_2d', FLOW_TAYLOR_GREEN_2D), named_kind_t('taylor_green', FLOW_TAYLOR_GREEN), &
    named_kind_t('turbulence_rogallo', FLOW_ROGALLO), named_kind_t('random-given-spectrum', FLOW_SPECTRUM), &
    named_kind_t('infile', FLOW_FILES), named_kind_t('backup', FLOW_BACKUP), named_kind_t(BACKUP_WORD//'*', FLOW_BACKUP_FILE)]

  type :: initial_params_t
    integer :: flow = FLOW_QUIESCENT
    character(:), allocatable :: word          !< the word for it that the user gives
    character(:), allocatable :: spectrum_file
    character(1024) :: file_u(3) = '' !< names of the fields of flow = infile
    real(rp) :: omega1 = 0            !< circulation of the ring, or mean energy
    integer :: seed = 0
  contains
    procedure :: backup => initial_backup
  end type initial_params_t

contains

  !> Declares and reads the keys of [InitialCondition].
  subroutine initial_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(initial_params_t), intent(inout) :: p
    character(:), allocatable :: word !< not allocated where keys are declared
    integer :: i
    call keys%section(SECTION, 'the flow at t = 0')
    call keys%kind('inicond', p%flow, 'none', FLOWS, 'initial velocity', required=.true., unbuilt=NO_FLOWS, instead=FOR_FLOWS, &
                   word=p%word)
    call keys%real('omega1', p%omega1, 0.0_rp, 'circulation of the vortex ring; mean kinetic energy of turbulence_rogallo')
    call keys%integer('seed', p%seed, 0, 'seed of random fields; the field does not depend on the number of ranks', min=0)
    call keys%inert('nu_smoothing', 'belongs to an initial condition that does not exist here')
    do i = 1, 3
      call keys%text('file_u'//AXES(i:i), word, 'none', 'HDF5 field with u_'//AXES(i:i)//' for infile')
      if (allocated(word)) p%file_u(i) = word
    end do
    call keys%inert('file_p', 'pressure is not a prognostic variable')
    call keys%text('inicond_spectrum_file', p%spectrum_file, 'none', 'text file with columns k, E(k) for random-given-spectrum')
  end subroutine initial_keys

  !> Returns the checkpoint that the user names as the initial flow, empty if there is none.
  pure function initial_backup(self) result(path)
    class(initial_params_t), intent(in) :: self
    character(:), allocatable :: path
    path = ''
    if (self%flow == FLOW_BACKUP_FILE) path = self%word(len(BACKUP_WORD) + 1:)
  end function initial_backup

  !> Checks that the initial flow has the keys that it needs, and adds a mistake to `errors` for each that is missing or wrong.
  !> `ring_radius` is [Geometry] Size.
  subroutine check_initial(c, p, is_2d, ring_radius, errors)
    type(config_t), intent(in) :: c
    type(initial_params_t), intent(in) :: p
    logical, intent(in) :: is_2d
    real(rp), intent(in) :: ring_radius
    type(message_list_t), intent(inout) :: errors
    character(*), parameter :: KEY = 'inicond'
    integer :: i
    select case (p%flow)
    case (FLOW_RING)
      if (is_2d) call c%complain(errors, SECTION, KEY, 'a vortex ring is three-dimensional and needs nx > 1')
      if (ring_radius <= 0) call c%complain(errors, 'Geometry', 'Size', 'the vortex ring needs a radius above 0')
    case (FLOW_ROGALLO)
      if (p%omega1 <= 0) call c%complain(errors, SECTION, 'omega1', 'the random field needs a mean kinetic energy above 0')
    case (FLOW_FILES)
      do i = 1, 3
        call need_file(c, errors, 'file_u'//AXES(i:i), trim(p%file_u(i)))
      end do
    case (FLOW_SPECTRUM)
      call need_file(c, errors, 'inicond_spectrum_file', p%spectrum_file)
    case (FLOW_TAYLOR_GREEN_2D)
      if (.not. is_2d) call c%complain(errors, SECTION, KEY, 'taylor_green_2d is a flow in the y-z plane: set nx = 1')
    case (FLOW_TAYLOR_GREEN)
      if (is_2d) call c%complain(errors, SECTION, KEY, 'taylor_green is three-dimensional; valid with nx = 1: taylor_green_2d')
    end select
  end subroutine check_initial

  !> Adds an error if a key does not name a file that exists.
  subroutine need_file(c, errors, key, name)
    type(config_t), intent(in) :: c
    type(message_list_t), intent(inout) :: errors
    character(*), intent(in) :: key, name
    logical :: exists
    if (name == 'none' .or. name == '') then
      call c%complain(errors, SECTION, key, 'this initial condition needs a file name here')
      return
    end if
    inquire (file=name, exist=exists)
    if (.not. exists) call c%complain(errors, SECTION, key, 'there is no file "'//name//'"')
  end subroutine need_file
end module fluid_initial_keys
