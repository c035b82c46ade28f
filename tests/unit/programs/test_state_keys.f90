! SPDX-License-Identifier: GPL-3.0-or-later
!> The state in a checkpoint of `flusi` and of `flusi --solid` depends on the keys that are written here, and on no others: a
!> restart with another value of one of them is refused.
program test_state_keys
  use base_errors, only: message_list_t
  use io_config, only: config_t
  use io_registry, only: registry_t
  use simulation_keys, only: register_all_keys
  use simulation_solid_keys, only: register_solid_keys
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: OF_FLOW(16) = [character(28) :: '[units] length', '[units] frequency', '[units] density', &
                                            '[Geometry] *', '[Penalization] iMask', '[Penalization] iPenalization', &
                                            '[Penalization] iMoving', '[Penalization] iChannel', '[Insects] LeftWing', &
                                            '[Insects] RightWing', '[Insects] WingShape', '[Insects] wing_length', &
                                            '[Insects] wing_stretch', '[Insects] BodyType', '[Insects] body_profile', &
                                            '[Insects] body_scale']
  character(*), parameter :: OF_SOLID(4) = [character(28) :: '[units] length', '[units] frequency', '[Motion] type', &
                                             '[Motion] wing']
  type(testkit_t) :: t
  type(registry_t), target :: of_flow_keys, of_solid_keys

  call t%start(parallel=.false.)
  call register_all_keys(of_flow_keys)
  call compare('flusi', of_flow_keys, OF_FLOW)
  call register_solid_keys(of_solid_keys)
  call compare('flusi --solid', of_solid_keys, OF_SOLID)
  call t%finish()

contains

  !> Checks that the keys of checkpoints in `registry` are those that are `expected`, in any order.
  subroutine compare(program, registry, expected)
    character(*), intent(in) :: program, expected(:)
    type(registry_t), intent(in) :: registry
    type(config_t) :: config
    type(message_list_t) :: errors, notices, patterns
    integer :: i, k
    call config%load_text('', 'none.ini', registry, errors, notices, .false.)
    patterns = config%state_keys()
    do i = 1, size(expected)
      call t%check(program//': the state depends on '//trim(expected(i)), &
                   any([(patterns%text(k) == expected(i), k=1, patterns%count())]))
    end do
    do k = 1, patterns%count()
      call t%check(program//': '//patterns%text(k)//' is expected', any(expected == patterns%text(k)))
    end do
  end subroutine compare
end program test_state_keys
