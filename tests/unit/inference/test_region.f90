! SPDX-License-Identifier: GPL-3.0-or-later
!> Where an unknown cause is said to be, which effects are said to be related, and what probability is stated, on the wing
!> in closed form of test_engine.
program test_region
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use base_random, only: random_stream_t
  use diagnosis_beam, only: beam_t, make_beam, E_DRIFT, E_SPAN
  use inference_calibration, only: calibration_t, find_statistics, statistics_t
  use inference_decision, only: grade_of, VERDICT_ADEQUATE, VERDICT_NAMED, VERDICT_SET
  use inference_design, only: build_design, design_t
  use inference_probability, only: follow_knots, calibrated_probability, MAP_OF_BENDING, MAP_OF_VIBRATION
  use inference_region, only: find_region, find_related, region_t, related_t
  use least_squares_state, only: solver_state_t
  use testkit, only: testkit_t
  implicit none
  integer, parameter :: N_EFFECTS = 12
  real(rp), parameter :: DISTANCE = 0.1_rp !< of places on the wing
  type(testkit_t) :: test
  type(beam_t), target :: beam
  type(design_t) :: design
  class(solver_state_t), allocatable :: state
  type(failure_t) :: failure

  call test%start(parallel=.false.)
  call make_beam(beam)
  call beam%observe(beam%null_point(), beam%sigma, 1)
  allocate (state)
  call build_design(beam, beam%null_point(), state, 1.0_rp, design, failure)
  call test%check('the design exists',.not. failure%failed)
  call test_one_place()
  call test_field()
  call test_related()
  call test_stated()
  call test%finish()

contains

  !> The place of a cause that is one pattern, each as likely as the others, is in the region with its probability: of 400 cases
  !> fewer than 340 would come with a probability below 1e-3 (binomial distribution) if 0.9 were true. Cases that are
  !> taken for a field, or for the other kind, have no such region.
  subroutine test_one_place()
    integer, parameter :: CASES = 400
    type(random_stream_t) :: stream
    type(region_t) :: region
    real(rp) :: z(design%k)
    integer :: i, n, f, at, held, other
    integer(i8), parameter :: SEED = 17
    stream = random_stream_t(seed=SEED, stream=1_i8)
    held = 0
    other = 0
    do i = 1, CASES
      f = 1 + modulo(i, size(design%families))
      call stream%gaussians(z)
      associate (family => design%families(f))
        at = 1 + int(stream%uniform()*size(family%shown))
        z = z + merge(8, -8, modulo(i, 4) < 2)*family%alone(:, at)
        call find_region(design, z, beam%pattern_site, DISTANCE, region)
        n = merge(1, 0, region%family == f .and. region%is_one_site)
        other = other + 1 - n
        if (n == 1 .and. any(region%pattern == family%shown(at))) held = held + 1
      end associate
    end do
    call test%check('most causes at one place are told to be such', other <= CASES/3)
    call test%check_below('the place is outside of its region in a tenth of all cases', &
                          real(CASES - other - held, rp), 0.15_rp*(CASES - other))
    call test%check('the region is not the whole wing: its shares add up to 0.9 and its last place is needed', &
                    is_smallest(region))
  end subroutine test_one_place

  !> Whether the region of one place holds 0.9, and would not without its least probable place.
  logical function is_smallest(region)
    type(region_t), intent(in) :: region
    is_smallest = sum(region%fraction) >= 0.9_rp .and. sum(region%fraction) - minval(region%fraction) < 0.9_rp
  end function is_smallest

  !> Two bumps of bending compliance at the ends of the wing, as strong as a ratio of 40, are two parts of the region, or
  !> one that holds both; what lies beside them by more than two places is not in it.
  subroutine test_field()
    type(region_t) :: region
    real(rp) :: z(design%k), site
    integer :: i, n
    logical :: has(2)
    associate (family => design%families(1))
      z = 40*(family%alone(:, findloc_of(family%shown, 2)) - family%alone(:, findloc_of(family%shown, 8)))
      call find_region(design, z, beam%pattern_site, DISTANCE, region)
      call test%check('two places are a field', region%is_found .and. .not. region%is_one_site)
      has = .false.
      do i = 1, size(region%pattern)
        site = beam%pattern_site(1, family%patterns(region%pattern(i)))
        has = has .or. abs(site - [0.15_rp, 0.75_rp]) < 0.11_rp
      end do
      call test%check('both are in the region', all(has))
      call test%check('parts come in the order of their shares, which add up to 1 at most', &
                      region%n_parts == maxval(region%part) .and. sum(region%fraction) < 1 + 1.0e-12_rp .and. &
                      sum(region%fraction, mask=region%part == 1) >= sum(region%fraction, mask=region%part == region%n_parts))
      call test%check('parts are connected, and apart from each other', &
                      are_parts(region, beam%pattern_site(:, family%patterns)))
      call find_region(design, z, beam%pattern_site, 10*DISTANCE, region)
      call test%check('with neighbours as far as the wing is long there is one part', region%n_parts == 1)
      call find_region(design, z, beam%pattern_site, 0.1_rp*DISTANCE, region)
      n = count([(all(abs(beam%pattern_site(1, family%patterns(region%pattern(i))) - &
                          beam%pattern_site(1, family%patterns(region%pattern(:i - 1)))) > 0.01_rp), &
                  i=1, size(region%pattern))])
      call test%check('and without neighbours every place is a part', region%n_parts == n .and. n > 1)
    end associate
  end subroutine test_field

  !> Whether places of different parts are no neighbours, and each place has one in its own part, if that has more than one.
  logical function are_parts(region, site) result(ok)
    type(region_t), intent(in) :: region
    real(rp), intent(in) :: site(:, :)
    logical :: is_alone
    integer :: i, j
    ok = .true.
    do i = 1, size(region%pattern)
      is_alone = count(region%part == region%part(i)) > 1
      do j = 1, size(region%pattern)
        if (i == j) cycle
        associate (gap => norm2(site(:, region%pattern(i)) - site(:, region%pattern(j))))
          if (region%part(i) /= region%part(j)) ok = ok .and. gap > 1.2_rp*DISTANCE
          if (region%part(i) == region%part(j) .and. gap <= 1.2_rp*DISTANCE) is_alone = .false.
        end associate
      end do
      ok = ok .and. .not. is_alone
    end do
  end function are_parts

  pure integer function findloc_of(values, value) result(at)
    integer, intent(in) :: values(:), value
    do at = 1, size(values)
      if (values(at) == value) return
    end do
    at = 0
  end function findloc_of

  !> A drift and a change along the span at once: both are related, the stronger one first, each with its share.
  subroutine test_related()
    type(calibration_t) :: calibration
    type(statistics_t) :: statistics
    type(related_t), allocatable :: related(:)
    real(rp) :: z(design%k), drift(design%k), whole
    integer :: span, order
    call calibration%init(design, N_EFFECTS, .true., 500, 3_i8)
    span = candidate_of(E_SPAN)
    order = candidate_of(E_DRIFT)
    associate (basis => design%candidates(span)%basis)
      drift = design%candidates(order)%basis(:, 1)
      drift = drift - matmul(basis, matmul(drift, basis))
      z = 20*drift/norm2(drift) + 10*basis(:, 1)
    end associate
    z = z*sqrt(1 + design%k/500.0_rp) ! |z|^2 = 500 + k
    call find_statistics(design, N_EFFECTS, .true., z, 0.0_rp, statistics)
    call find_related(design, calibration, statistics, z, related)
    call test%check('two effects are related at least', size(related) >= 2)
    if (size(related) < 2) return
    call test%check('the stronger one first', related(1)%effect == E_DRIFT .and. any(related%effect == E_SPAN))
    whole = sum(z**2) - design%k
    call test%check_close('with the share of what noise does not make', related(1)%explained, &
                          (statistics%squares(order) - 1)/whole, 1.0e-12_rp, 0.0_rp)
    z = 0
    call find_statistics(design, N_EFFECTS, .true., z, 0.0_rp, statistics)
    call find_related(design, calibration, statistics, z, related)
    call test%check('nothing is related to nothing', size(related) == 0)
  end subroutine test_related

  !> First candidate of an effect.
  pure integer function candidate_of(e) result(c)
    integer, intent(in) :: e
    do c = 1, size(design%candidates)
      if (design%candidates(c)%effect == e) return
    end do
    c = 0
  end function candidate_of

  !> Straight lines between knots; never beyond their ends; p itself without any.
  subroutine test_stated()
    real(rp), parameter :: X(3) = [0.2_rp, 0.6_rp, 0.8_rp], Y(3) = [0.1_rp, 0.5_rp, 0.9_rp]
    real(rp) :: p, before
    integer :: i, map
    call test%check_close('half way between knots', follow_knots(X, Y, 0.7_rp), 0.7_rp, 1.0e-15_rp, 0.0_rp)
    call test%check_close('before the first', follow_knots(X, Y, 0.0_rp), 0.1_rp, 0.0_rp, 0.0_rp)
    call test%check_close('behind the last', follow_knots(X, Y, 1.0_rp), 0.9_rp, 0.0_rp, 0.0_rp)
    call test%check_close('at a knot', follow_knots(X, Y, 0.6_rp), 0.5_rp, 1.0e-15_rp, 0.0_rp)
    call test%check_close('without knots', follow_knots(X(:0), Y(:0), 0.37_rp), 0.37_rp, 0.0_rp, 0.0_rp)
    do map = MAP_OF_BENDING, MAP_OF_VIBRATION
      before = 0
      do i = 0, 100
        p = calibrated_probability(map, VERDICT_NAMED, i/100.0_rp)
        call test%check('what is stated for names is a probability and never falls', p >= before .and. p <= 1)
        before = p
      end do
    end do
    call test%check('names have grade A, sets B, other verdicts none', &
                    grade_of(VERDICT_NAMED)//grade_of(VERDICT_SET)//grade_of(VERDICT_ADEQUATE) == 'AB ')
  end subroutine test_stated
end program test_region
