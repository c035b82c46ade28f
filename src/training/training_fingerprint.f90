! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the number by which a checkpoint recognises its training.
module training_fingerprint
  use base_checksum, only: checksum_add, checksum_reals, checksum_text
  use base_fingerprint, only: fingerprint_t
  use base_kinds, only: i8, rp
  use measurement_experiment, only: experiment_t
  use solid_effect_sites, only: effect_site_lines
  use solid_restart, only: points_fingerprint
  use training_case, only: training_case_t
  implicit none
  private
  public :: fingerprint_of

contains

  !> Returns the number for everything that determines the search, but not how long it runs. The settings stay as they are.
  integer(i8) function fingerprint_of(settings) result(fingerprint)
    class(training_case_t), intent(inout) :: settings
    type(fingerprint_t) :: entries
    integer :: i
    call settings%visit(entries)
    fingerprint = checksum_text(entries%text('restarts')//entries%text('search_weights')//entries%text('search_constants'))
    associate (e => settings%experiment)
      call add([entries%numbers('free_numbers'), entries%numbers('free_lower'), entries%numbers('free_upper'), &
                entries%numbers('free_is_log'), entries%numbers('search_seed'), entries%numbers('search_lambda'), &
                entries%numbers('search_sigma0'), entries%numbers('solver_tolerance'), entries%numbers('solver_step_limit'), &
                entries%numbers('solver_factorisation_limit'), entries%numbers('use_chi2'), entries%numbers('starts_at_wing'), &
                merge([1.0_rp], [0.0_rp], e%model%params%cross_springs)], 0_i8)
      call add([(e%model%params%get(i), i=1, e%model%params%count()), e%model%params%slack, e%model%params%slack_width], &
               1000000_i8)
      call add([e%instrument%values, entries%numbers('free_instrument_numbers')], 2000000_i8)
      call add([entries%numbers('search_mu'), entries%numbers('search_c_m'), entries%numbers('search_c_sigma'), &
                entries%numbers('search_d_sigma'), entries%numbers('search_c_c'), entries%numbers('search_c_1'), &
                entries%numbers('search_c_mu'), entries%numbers('search_alpha_minus')], 3000000_i8)
      call add([e%measurement%x, e%measurement%y, entries%numbers('n_stages')], 4000000_i8)
      fingerprint = checksum_add(fingerprint, points_fingerprint(e%model))
      fingerprint = checksum_add(fingerprint, checksum_text(effect_site_lines(e%model%params%effects)))
      fingerprint = checksum_add(fingerprint, measurement_fingerprint(e))
      fingerprint = checksum_add(fingerprint, entries%rest())
    end associate

  contains

    subroutine add(numbers, first)
      real(rp), intent(in) :: numbers(:)
      integer(i8), intent(in) :: first
      fingerprint = checksum_add(fingerprint, checksum_reals(numbers, first))
    end subroutine add
  end function fingerprint_of

  !> Returns the checksum of the measured values, of their points, and of the loads.
  integer(i8) function measurement_fingerprint(e) result(number)
    type(experiment_t), intent(in) :: e
    integer :: i, l
    number = 0
    do l = 1, size(e%comparisons)
      number = checksum_add(number, checksum_reals([e%comparisons(l)%measured, e%comparisons(l)%sigma, &
                                                    e%measurement%loads(l)%force, e%measurement%loads(l)%point, &
                                                    e%measurement%loads(l)%direction], l*10000000_i8))
      associate (load => e%measurement%loads(l))
        if (load%order > 0 .or. any([load%time, load%hold] >= 0)) & ! drift and creep depend on them
          number = checksum_add(number, checksum_reals([real(load%order, rp), load%time, load%hold], 6000000_i8 + 100*l))
      end associate
    end do
    do i = 1, size(e%measurement%observations)
      associate (one => e%measurement%observations(i))
        number = checksum_add(number, checksum_reals([one%point, one%axis, real([one%load, one%quantity, one%zero], rp)], &
                                                   5000000_i8 + 100*i))
      end associate
    end do
  end function measurement_fingerprint
end module training_fingerprint
