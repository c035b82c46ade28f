! SPDX-License-Identifier: GPL-3.0-or-later
!> The share of errors that neighbours have in common is found from the data: 0, 0.36 and 0.7 of the variance, whatever was
!> believed before, and also beside a wave of an unknown cause, which is no error.
!>
!> Means over draws, with four standard errors from their scatter, and the resolution of nine steps of golden section
!> on (0, 0.9): 0.9 x 0.618^7/2 = 0.016.
program test_noise_fraction
  use base_kinds, only: i8, rp
  use diagnosis_noise, only: check_declared_variance, noise_estimate_t
  use diagnosis_wing_bins, only: noise_model_t
  use inference_noise_fraction, only: find_noise_fraction
  use noise_scans, only: make_scans, scans_t
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: DRAWS = 30
  real(rp), parameter :: RESOLUTION = 0.016_rp
  type(testkit_t) :: t

  call t%start(parallel=.false.)
  call find('0.36 of 0', 0.36_rp, 0.0_rp, 0.0_rp)
  call find('0.36 of 0.8', 0.36_rp, 0.8_rp, 0.0_rp)
  call find('0.7', 0.7_rp, 0.2_rp, 0.0_rp)
  call find('0.36 beside a wave', 0.36_rp, 0.0_rp, 1.0_rp)
  call find_none()
  call find_bound()
  call judge()
  call change()
  call t%finish()

contains

  subroutine find(name, truth, before, wave)
    character(*), intent(in) :: name
    real(rp), intent(in) :: truth, before, wave
    type(scans_t) :: scans
    real(rp) :: found(DRAWS), mean, error, independent
    integer :: k
    logical :: is_new
    do k = 1, DRAWS
      call make_scans(scans, truth, wave, int(k, i8))
      call find_noise_fraction(scans, [3.0_rp], solver_state_t(), 1 - before, 0.0_rp, independent, is_new)
      found(k) = 1 - independent
    end do
    mean = sum(found)/DRAWS
    error = sqrt(sum((found - mean)**2)/(DRAWS - 1)/DRAWS)
    call t%check_close(name, mean, truth, atol=4*error + RESOLUTION)
    call t%check('single ones scatter by less than 0.1: '//name, error*sqrt(real(DRAWS, rp)) < 0.1_rp)
  end subroutine find

  !> No common errors: the smallest share that the section can give, or little more.
  subroutine find_none()
    type(scans_t) :: scans
    real(rp) :: independent
    logical :: is_new
    call make_scans(scans, 0.0_rp, 0.0_rp, 99_i8)
    call find_noise_fraction(scans, [3.0_rp], solver_state_t(), 0.5_rp, 0.0_rp, independent, is_new)
    call t%check('none are found where there are none', independent > 0.9_rp .and. is_new)
  end subroutine find_none

  !> Of errors of which 0.7 are in common, no more than the bound permits is found: the rest is a misfit.
  subroutine find_bound()
    type(scans_t) :: scans
    real(rp) :: independent
    logical :: is_new
    call make_scans(scans, 0.7_rp, 0.0_rp, 5_i8)
    call find_noise_fraction(scans, [3.0_rp], solver_state_t(), 1.0_rp, 0.6_rp, independent, is_new)
    call t%check('no more than the bound permits is found', independent > 0.6_rp .and. independent < 0.6_rp + RESOLUTION)
  end subroutine find_bound

  !> Errors that are declared as twice what they are, 1/4 of the variance, are told too large; those that are declared right, or
  !> as four fifths of what they are, are not; and nothing is said where neighbours have been asked already.
  subroutine judge()
    type(noise_estimate_t) :: estimate
    estimate%is_found = .true.
    estimate%warning = ''
    estimate%model%length = 1
    estimate%model%factor = 0.5_rp
    call check_declared_variance(estimate, 2.0_rp)
    call t%check('right errors are not warned of', estimate%warning == '')
    call check_declared_variance(estimate, 3.0_rp)
    call t%check('nor are those that are declared too small by a fifth', estimate%warning == '')
    call check_declared_variance(estimate, 0.5_rp)
    call t%check('errors declared twice as large are', index(estimate%warning, 'too large') > 0)
    estimate%warning = 'neighbours have told'
    call check_declared_variance(estimate, 0.5_rp)
    call t%check('once', estimate%warning == 'neighbours have told')
    estimate%warning = ''
    estimate%model%length = 0
    call check_declared_variance(estimate, 0.5_rp)
    call t%check('and not where neighbours share nothing', estimate%warning == '')
    estimate%is_found = .false.
    estimate%model%factor = 1
    call check_declared_variance(estimate, 2.0_rp)
    call t%check('without neighbours errors that are nearly right are not warned of', estimate%warning == '')
    call check_declared_variance(estimate, 9.0_rp)
    call t%check('without neighbours the warning says how much too small errors are', &
                 index(estimate%warning, '3.0 times as much as the declared errors') > 0)
    estimate%warning = ''
    call check_declared_variance(estimate, 0.1_rp)
    call t%check('or that they are too large', index(estimate%warning, 'too large') > 0)
  end subroutine judge

  !> Another fraction of a model changes the variance that neighbours share, and no other; the same fraction changes nothing.
  subroutine change()
    type(noise_model_t) :: model, other
    model = noise_model_t(white=0.3_rp, length=1.0_rp, factor=0.7_rp, unloaded=2.0_rp)
    other = model%with_independent(0.6_rp)
    call t%check_close('independent errors stay', other%white*other%factor, 0.21_rp, rtol=4*epsilon(1.0_rp))
    call t%check_close('shared ones are the rest', (1 - other%white)*other%factor, 0.14_rp, rtol=4*epsilon(1.0_rp))
    call t%check('the model itself stays', model%white == 0.3_rp .and. other%length == 1.0_rp .and. other%unloaded == 2.0_rp)
    other = model%with_independent(model%white)
    call t%check('its own fraction changes nothing', other%factor == 0.7_rp)
  end subroutine change
end program test_noise_fraction
