! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the entries of the catalogue that describe energy loss, which only records of a vibrating wing can show. The baseline has
!> mass-proportional damping, as every wing comes to rest. Without records the catalogue has none of these entries.
module diagnosis_wing_damping
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use base_parameter, only: parameter_t
  use diagnosis_wing_entries, only: append_variant, catalogue_t
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_DAMPING, KIND_RELAXATION, KIND_RELAXATION_TIME
  use inference_simulator, only: variant_t
  use measurement_experiment, only: experiment_t
  use solid_damping_effects, only: describe_damping, DAMPING_JOINTS, DAMPING_MASS, DAMPING_RELAXATION, DAMPING_STIFFNESS
  implicit none
  private
  public :: add_damping, enter_damping

  real(rp), parameter :: DECADE = 2.302585092994046_rp
  real(rp), parameter :: FACTOR = 2.0_rp !< between the times of relaxation that are tried

contains

  !> Adds a parameter to the baseline. If there are records, it fits damping in proportion to the mass. It begins with one that
  !> ends the motion within the longest of them, and the sd of its logarithm is a decade.
  subroutine add_damping(c, e)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(parameter_t) :: p
    real(rp) :: time, turns
    integer :: n
    if (e%measurement%count_series() == 0) return
    call find_times(e, time, turns)
    p = describe_damping(DAMPING_MASS, time, turns)
    p%is_log = .true.
    p%null = log(2/time)
    p%prior_sd = DECADE
    p%lower = p%null - 4*DECADE
    p%upper = log(max(20.0_rp, turns)/time) ! above the start, however short the record
    n = c%add(wing_parameter(p, KIND_DAMPING, DAMPING_MASS))
  end subroutine add_damping

  !> Finds the length [s] of the longest record, and how many radians the wing turns in it at a tenth of the sampling rate: a
  !> record that resolves a motion has about ten samples in each of its periods.
  subroutine find_times(e, time, turns)
    type(experiment_t), intent(in) :: e
    real(rp), intent(out) :: time, turns
    integer :: i
    time = 0
    do i = 1, e%measurement%count_series()
      associate (s => e%measurement%series(i))
        if (s%length() <= time) cycle
        time = s%length()
        turns = TWO_PI*0.1_rp*s%rate*time
      end associate
    end do
  end subroutine find_times

  !> Enters the effects of damping.
  subroutine enter_damping(c, e)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(variant_t), allocatable :: variants(:)
    type(parameter_t) :: factor_of_time
    type(wing_parameter_t) :: relaxation
    real(rp) :: time, turns, tau
    integer :: n, of_time
    if (e%measurement%count_series() == 0) return
    call find_times(e, time, turns)
    call enter_one(c, DAMPING_STIFFNESS, 'stiffness_damping', 'damping in proportion to the stiffness', &
                   'What bends fast is damped more than still air would: the cuticle takes energy at every rate.')
    call enter_one(c, DAMPING_JOINTS, 'joint_friction', 'friction in the joints of veins', &
                   'The joints of veins take energy when they turn.')
    allocate (variants(0))
    tau = 0.5_rp*time/turns
    do while (tau < 0.5_rp*time)
      relaxation = damping_parameter(DAMPING_RELAXATION, KIND_RELAXATION, size(c%parameters) + 2)
      relaxation%time = tau
      n = c%add(relaxation)
      call append_variant(variants, 'with a relaxation time of about '//milliseconds(tau)//' ms', n, [0.0_rp, 0.0_rp])
      factor_of_time%unit = '1'
      factor_of_time%name = 'relaxation_time_factor'
      factor_of_time%is_log = .true.
      factor_of_time%prior_sd = log(FACTOR)
      factor_of_time%lower = -log(FACTOR)
      factor_of_time%upper = log(FACTOR)
      of_time = c%add(wing_parameter(factor_of_time, KIND_RELAXATION_TIME, n))
      variants(size(variants))%columns = [n, of_time]
      tau = FACTOR*tau
    end do
    call c%enter('viscoelasticity', 'viscoelastic veins and membrane', &
                 'The wing is stiffer when it bends fast, and loses energy in between: its material relaxes.', .false., '', &
                 variants)

  contains

    !> Enters one damping parameter as a separate effect.
    subroutine enter_one(c, number, name, title, sentence)
      type(catalogue_t), intent(inout) :: c
      integer, intent(in) :: number
      character(*), intent(in) :: name, title, sentence
      type(variant_t), allocatable :: one(:)
      allocate (one(0))
      n = c%add(damping_parameter(number, KIND_DAMPING, number))
      call append_variant(one, '', n, [0.0_rp, 0.0_rp])
      call c%enter(name, title, sentence, .false., '', one)
    end subroutine enter_one

    type(wing_parameter_t) function damping_parameter(effect, kind, number)
      integer, intent(in) :: effect, kind, number
      type(parameter_t) :: p
      p = describe_damping(effect, time, turns)
      damping_parameter = wing_parameter(p%as_coordinate(p%null), kind, number)
    end function damping_parameter

  end subroutine enter_damping

  !> Returns a time [s] in milliseconds.
  function milliseconds(time) result(text)
    real(rp), intent(in) :: time
    character(:), allocatable :: text
    character(16) :: buffer
    write (buffer, '(f12.3)') 1000*time
    text = trim(adjustl(buffer))
  end function milliseconds
end module diagnosis_wing_damping
