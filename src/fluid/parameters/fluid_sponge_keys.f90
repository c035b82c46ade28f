! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the vorticity sponge from the keys of [Sponge].
module fluid_sponge_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use fluid_substitutes, only: FOR_SPONGES
  use io_config, only: config_t
  use io_keys, only: keys_t
  implicit none
  private
  public :: sponge_params_t, sponge_keys, sponge_faces, check_sponge
  public :: SPONGES, SPONGE_CAVITY, SPONGE_OPEN_Z, SPONGE_X, SPONGE_X_Y, SPONGE_X_Z, &
            SPONGE_OUTLET_X, SPONGE_TOP, SPONGE_FRAME

  integer, parameter :: SPONGE_CAVITY = 1, SPONGE_OPEN_Z = 2, SPONGE_X = 3, SPONGE_X_Y = 4, SPONGE_X_Z = 5, SPONGE_OUTLET_X = 6, &
                        SPONGE_TOP = 7, SPONGE_FRAME = 8
  type(named_kind_t), parameter :: SPONGES(8) = [ &
    named_kind_t('cavity', SPONGE_CAVITY), named_kind_t('cavity_open_z', SPONGE_OPEN_Z), named_kind_t('xmin_xmax', SPONGE_X), &
    named_kind_t('xmin_xmax_ymin_ymax', SPONGE_X_Y), named_kind_t('xmin_xmax_zmin_zmax', SPONGE_X_Z), &
    named_kind_t('outlet_x', SPONGE_OUTLET_X), named_kind_t('top_cover', SPONGE_TOP), named_kind_t('2D_frame', SPONGE_FRAME)]

  type :: sponge_params_t
    logical :: is_on = .false.
    integer :: kind = SPONGE_TOP  !< which faces of the box
    real(rp) :: damping_time = 0  !< T
    integer :: thickness = 0      !< points
  end type sponge_params_t

contains

  !> Declares and reads the keys of [Sponge].
  subroutine sponge_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(sponge_params_t), intent(inout) :: p
    call keys%section('Sponge', 'vorticity sponge')
    call keys%switch('iVorticitySponge', p%is_on, .false., 'damp the vorticity in a frame of the box')
    call keys%kind('iSpongeType', p%kind, 'top_cover', SPONGES, 'which faces of the box', unbuilt='moving_insect*', &
                   instead=FOR_SPONGES)
    call keys%real('eps_sponge', p%damping_time, 0.0_rp, 'damping time C_sp; required when the sponge is on', unit='T', &
                   min=0.0_rp)
    call keys%integer('sponge_thickness', p%thickness, 0, 'thickness of the sponge', unit='points', min=0)
  end subroutine sponge_keys

  !> Adds mistakes to `errors` and doubts to `notices`; the grid has `n` points.
  subroutine check_sponge(c, p, n, errors, notices)
    type(config_t), intent(in) :: c
    type(sponge_params_t), intent(in) :: p
    integer, intent(in) :: n(3)
    type(message_list_t), intent(inout) :: errors
    type(message_list_t), intent(inout), optional :: notices
    logical :: both(3), last(3)
    if (.not. p%is_on) return
    if (p%damping_time <= 0) call c%complain(errors, 'Sponge', 'eps_sponge', 'the sponge needs a damping time above 0')
    if (p%thickness <= 0) call c%complain(errors, 'Sponge', 'sponge_thickness', &
                                                 'the sponge needs a thickness of at least one point')
    call sponge_faces(p%kind, both, last)
    if (n(1) <= 4 .and. .not. any(both(2:)) .and. .not. any(last(2:))) &
      call c%complain(errors, 'Sponge', 'iSpongeType', 'this sponge lies at the ends of x, and a two-dimensional flow '// &
                      '(nx = 1) has none')
    if (.not. present(notices)) return
    if (any(both .and. 2*p%thickness >= n .and. n > 4) .or. &
        any(last .and. p%thickness >= n .and. n > 4)) &
      call c%complain(notices, 'Sponge', 'sponge_thickness', 'the sponge fills the box and damps the whole flow: set a '// &
                      'smaller sponge_thickness')
  end subroutine check_sponge

  !> Returns the directions in which a type of sponge covers both ends of the box, and those in which it covers the last end only.
  pure subroutine sponge_faces(kind, both, last)
    integer, intent(in) :: kind
    logical, intent(out) :: both(3), last(3)
    last = [kind == SPONGE_OUTLET_X, .false., kind == SPONGE_TOP]
    select case (kind)
    case (SPONGE_CAVITY)
      both = .true.
    case (SPONGE_OPEN_Z, SPONGE_X_Y)
      both = [.true., .true., .false.]
    case (SPONGE_X)
      both = [.true., .false., .false.]
    case (SPONGE_X_Z)
      both = [.true., .false., .true.]
    case (SPONGE_FRAME)
      both = [.false., .true., .true.]
    case default
      both = .false.
    end select
  end subroutine sponge_faces
end module fluid_sponge_keys
