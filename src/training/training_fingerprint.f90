! SPDX-License-Identifier: GPL-3.0-or-later
!> Computes the number by which a checkpoint recognises its training.
module training_fingerprint
  use base_checksum, only: checksum_add, checksum_reals, checksum_text
  use base_kinds, only: i8, rp
  use solid_effect_sites, only: effect_site_lines
  use solid_restart, only: points_fingerprint
  use training_case, only: training_case_t
  implicit none
  private
  public :: fingerprint_of

contains

  !> What determines the search, but not how long it goes on.
  integer(i8) function fingerprint_of(settings) result(fingerprint)
    class(training_case_t), intent(in) :: settings
    integer :: i, l
    fingerprint = checksum_text(settings%restarts//settings%search%weights//settings%search%constants)
    associate (e => settings%experiment, o => settings%search, s => settings%free_parameters)
      fingerprint = checksum_add(fingerprint, points_fingerprint(e%model))
      fingerprint = checksum_add(fingerprint, checksum_text(effect_site_lines(e%model%params%effects)))
      fingerprint = checksum_add(fingerprint, checksum_reals([e%instrument%values, real(s%instrument_numbers, rp)], 2000000_i8))
      fingerprint = checksum_add(fingerprint, &
           checksum_reals([real(s%numbers, rp), s%lower, s%upper, merge(1.0_rp, 0.0_rp, s%is_log), &
                            real(o%seed, rp), real(o%lambda, rp), o%sigma0, e%options%tolerance, e%options%step_limit, &
           real(e%options%factorisation_limit, rp), merge(1.0_rp, 0.0_rp, [settings%use_chi2, settings%starts_at_wing, &
                                                                                 e%model%params%cross_springs])], 0_i8))
      fingerprint = checksum_add(fingerprint, checksum_reals([(e%model%params%get(i), i=1, e%model%params%count()), &
                                                e%model%params%slack, e%model%params%slack_width], 1000000_i8))
      fingerprint = checksum_add(fingerprint, checksum_reals([real(o%mu, rp), o%c_m, o%c_sigma, o%d_sigma, o%c_c, o%c_1, o%c_mu, &
                                                o%alpha_minus], 3000000_i8))
      fingerprint = checksum_add(fingerprint, checksum_reals([e%measurement%x, e%measurement%y, real(settings%n_stages, rp)], &
                                               4000000_i8))
      do l = 1, size(e%comparisons)
        fingerprint = checksum_add(fingerprint, checksum_reals([e%comparisons(l)%measured, e%comparisons(l)%sigma, &
                                                  e%measurement%loads(l)%force, e%measurement%loads(l)%point, &
                                                  e%measurement%loads(l)%direction], l*10000000_i8))
      end do
      do i = 1, size(e%measurement%observations)
        associate (one => e%measurement%observations(i))
          fingerprint = checksum_add(fingerprint, checksum_reals([one%point, one%axis, &
                                                    real([one%load, one%quantity, one%zero], rp)], &
                                                   5000000_i8 + 100*i))
        end associate
      end do
    end associate
  end function fingerprint_of
end module training_fingerprint
