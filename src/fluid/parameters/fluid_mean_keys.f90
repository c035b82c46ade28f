! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the mean flow from the keys of [MeanFlow].
module fluid_mean_keys
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use fluid_substitutes, only: FOR_MEAN_FLOWS
  use io_config, only: config_t
  use io_keys, only: keys_t
  implicit none
  private
  public :: mean_params_t, mean_keys, fix_mean_flow, drop_idle_velocity, MEAN_FREE, MEAN_FIXED, MEAN_SINUSOIDAL, MEAN_DYNAMIC

  character(*), parameter :: AXES = 'xyz'

  integer, parameter :: MEAN_FREE = 1, MEAN_FIXED = 2, MEAN_SINUSOIDAL = 3, MEAN_DYNAMIC = 4
  type(named_kind_t), parameter :: MEAN_FLOWS(4) = [named_kind_t('free', MEAN_FREE), named_kind_t('fixed', MEAN_FIXED), &
                                                    named_kind_t('sinusoidal', MEAN_SINUSOIDAL), &
                                                    named_kind_t('dynamic', MEAN_DYNAMIC)]

  type :: mean_params_t
    integer :: kind(3) = MEAN_FREE
    real(rp) :: velocity(3) = 0   !< L/T
    logical :: has_velocity(3) = .false. !< the user gives it
    real(rp) :: mass = 0          !< mass of the fluid that a dynamic mean flow accelerates
    real(rp) :: frequency = 0     !< of sinusoidal mean flow, 1/T
    logical :: has_ramp = .false. !< the force of dynamic mean flow begins smoothly
    real(rp) :: ramp = 0, release = 0 !< its duration and its start, T
    integer :: old_switch = 0     !< 1: all components are fixed
  end type mean_params_t

contains

  !> Declares and reads the keys of [MeanFlow].
  subroutine mean_keys(keys, p)
    type(keys_t), intent(inout) :: keys
    type(mean_params_t), intent(inout) :: p
    integer :: i
    call keys%section('MeanFlow', 'velocity of the mean (0,0,0) mode')
    do i = 1, 3
      call keys%kind('iMeanFlow_'//AXES(i:i), p%kind(i), 'free', MEAN_FLOWS, 'free: follows the forces; fixed: prescribed; '// &
                     'sinusoidal: u sin(2 pi f t); dynamic: accelerated by the reaction of the solids', &
                     unbuilt='accelerate_to_unity', instead=FOR_MEAN_FLOWS)
      call keys%real('u'//AXES(i:i), p%velocity(i), 1.0_rp, 'mean velocity in '//AXES(i:i), unit='L/T', &
                     given=p%has_velocity(i))
    end do
    call keys%integer('iMeanFlow', p%old_switch, 0, 'old FLUSI switch: 1 fixes all three components', min=0, max=1)
    call keys%real('m_fluid', p%mass, 999.0e9_rp, 'mass of fluid that dynamic mean flow accelerates', unit='M', above=0.0_rp)
    call keys%real('umean_freq', p%frequency, 0.0_rp, 'frequency of sinusoidal mean flow', unit='1/T', min=0.0_rp)
    call keys%switch('iMeanFlowStartupConditioner', p%has_ramp, .false., 'ramp up the force of dynamic mean flow')
    call keys%real('tau_meanflow', p%ramp, 0.0_rp, 'duration of the ramp', unit='T', min=0.0_rp)
    call keys%real('T_release_meanflow', p%release, 0.0_rp, 'start of the ramp', unit='T', min=0.0_rp)
  end subroutine mean_keys

  !> Applies FLUSI's single switch for all components. A contradiction goes to `errors`.
  subroutine fix_mean_flow(c, p, errors)
    type(config_t), intent(in) :: c
    type(mean_params_t), intent(inout) :: p
    type(message_list_t), intent(inout) :: errors
    character(*), parameter :: OLD = 'iMeanFlow'
    integer :: i
    if (p%old_switch /= 1) return
    do i = 1, 3
      if (any(p%kind(i) == [MEAN_SINUSOIDAL, MEAN_DYNAMIC])) &
        call c%complain(errors, 'MeanFlow', OLD, OLD//' = 1 contradicts '//OLD//'_'//AXES(i:i))
      p%kind(i) = MEAN_FIXED
    end do
  end subroutine fix_mean_flow

  !> Sets to 0 the components of the velocity that nothing gives to the fluid, so that no number of the run refers to a wind that
  !> does not blow: for a flow that does not begin with the velocity of [MeanFlow], those that no kind prescribes. Adds a notice
  !> if the user gives such a component. A flow from a checkpoint, `continues`, keeps the components that the user gives, since it
  !> may have begun with them.
  subroutine drop_idle_velocity(c, p, continues, notices)
    type(config_t), intent(in) :: c
    type(mean_params_t), intent(inout) :: p
    logical, intent(in) :: continues
    type(message_list_t), intent(inout), optional :: notices
    character(:), allocatable :: cure
    integer :: i
    do i = 1, 3
      if (.not. any(p%kind(i) == [MEAN_FREE, MEAN_DYNAMIC]) .or. (continues .and. p%has_velocity(i))) cycle
      cure = '[InitialCondition] inicond = MeanFlow'
      if (p%kind(i) == MEAN_FREE) cure = cure//', or iMeanFlow_'//AXES(i:i)//' = fixed'
      if (present(notices) .and. p%has_velocity(i) .and. abs(p%velocity(i)) > 0) &
        call c%complain(notices, 'MeanFlow', 'u'//AXES(i:i), 'has no effect: with this inicond the flow begins without a wind, '// &
                        'and iMeanFlow_'//AXES(i:i)//' does not hold one; for a wind set '//cure)
      p%velocity(i) = 0
    end do
  end subroutine drop_idle_velocity
end module fluid_mean_keys
