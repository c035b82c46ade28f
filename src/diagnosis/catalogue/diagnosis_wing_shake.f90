! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the entry of the catalogue that describes a motion of the base which was not recorded. Only records of motion show it.
module diagnosis_wing_shake
  use base_cause, only: cause_t
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use base_text, only: number_text
  use diagnosis_wing_entries, only: append_variant, catalogue_t
  use diagnosis_wing_parameters, only: wing_parameter, wing_parameter_t, KIND_SHAKE
  use inference_simulator, only: variant_t
  use measurement_experiment, only: experiment_t
  use measurement_series_causes, only: list_series_causes
  use solid_ringing, only: EXCITED_BASE, SHAKE_RATE
  implicit none
  private
  public :: enter_shake

  !> Frequencies are SPACING/length of the record apart, from one turn in it to a fourth of its samples in a second.
  real(rp), parameter :: SPACING = 0.7_rp, HIGHEST = 0.25_rp
  integer, parameter :: MOST = 64 !< frequencies of a record; more would cost too much

contains

  !> Enters a motion of the base at each of several frequencies, for each record of a release or a tap in turn.
  subroutine enter_shake(c, e)
    type(catalogue_t), intent(inout) :: c
    type(experiment_t), intent(in) :: e
    type(cause_t), allocatable :: list(:)
    type(variant_t), allocatable :: variants(:)
    real(rp) :: hertz, apart
    integer :: i, k
    allocate (variants(0))
    list = list_series_causes(1.0_rp, 1.0_rp)
    do i = 1, e%measurement%count_series()
      associate (s => e%measurement%series(i))
        if (s%excitation == EXCITED_BASE) cycle
        apart = max(SPACING/s%length(), HIGHEST*s%rate/MOST)
        do k = 0, MOST - 1
          hertz = 1/s%length() + k*apart
          if (hertz > HIGHEST*s%rate) exit
          list = list_series_causes(maxval(abs(s%values))*TWO_PI*hertz*merge(1.0_rp, TWO_PI*hertz, s%is_velocity), &
                                    log(1 + apart/hertz))
          call enter_frequency(c, list(1), i, hertz, variants)
          variants(size(variants))%label = 'at about '//number_text(nint(hertz))//' Hz in the record '//s%name
        end do
      end associate
    end do
    if (size(variants) > 0) call c%enter(list(1), '', variants)
  end subroutine enter_shake

  !> Appends the motion of the base in record i at a frequency [Hz] to the variants.
  subroutine enter_frequency(c, cause, i, hertz, variants)
    type(catalogue_t), intent(inout) :: c
    type(cause_t), intent(in) :: cause
    integer, intent(in) :: i
    real(rp), intent(in) :: hertz
    type(variant_t), allocatable, intent(inout) :: variants(:)
    type(wing_parameter_t) :: one
    integer :: k, n(3), first
    first = size(c%parameters)
    do k = 1, 3
      associate (p => cause%parameters(k))
        one = wing_parameter(p%value%as_coordinate(p%value%null), KIND_SHAKE, p%number)
        one%time = 1/hertz
        one%record = i
        one%partner = first + SHAKE_RATE
        n(k) = c%add(one)
      end associate
    end do
    call append_variant(variants, '', n(1), [0.0_rp, 0.0_rp])
    variants(size(variants))%columns = n
  end subroutine enter_frequency
end module diagnosis_wing_shake
