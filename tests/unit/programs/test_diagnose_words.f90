! SPDX-License-Identifier: GPL-3.0-or-later
!> Every parameter of every cause of the catalogue, of the wing in the file that the first argument names, under two loads and
!> with a natural mode, has a sentence with sign, size, unit and interval, above and below what was assumed; and sentences of
!> known values are those that are written here.
program test_diagnose_words
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_wording, only: wording_t
  use diagnose_findings, only: make_finding
  use diagnose_wordings, only: find_wording
  use diagnose_words, only: finding_t, finding_text
  use diagnosis_wing_catalogue, only: catalogue_t, make_catalogue
  use loaded_wing, only: wing_of_argument
  use measurement_data, only: measurement_t
  use measurement_experiment, only: experiment_t
  use measurement_instrument, only: instrument_t
  use measurement_instrument_causes, only: NONLINEARITY
  use solid_params, only: default_params, solid_params_t
  use solid_statics, only: static_options_t
  use solid_wing, only: wing_t
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: SURE = ' with 90 % confidence', PRESENT = '; the input assumes that it is present'
  type(testkit_t) :: t
  type(wing_t), target :: wing
  type(experiment_t), target :: bare
  type(catalogue_t) :: catalogue
  integer :: e, v, k, n_causes

  call t%start(parallel=.false.)
  wing = wing_of_argument()
  call make()
  n_causes = 0
  do e = 1, size(catalogue%effects)
    associate (effect => catalogue%effects(e))
      if (size(effect%variants) > 0) n_causes = n_causes + 1
      do v = 1, min(2, size(effect%variants)) ! one place of a scan is as good as another
        do k = 1, size(effect%variants(v)%columns)
          call try(effect%name, effect%variants(v)%label, effect%variants(v)%columns(k))
        end do
      end do
    end associate
  end do
  call t%check('the catalogue has its 35 causes', n_causes == 35 .and. size(catalogue%effects) == 35)
  call bounded('soft', 1.0e-4_rp, 1.0e2_rp)
  call bounded('damage', 1.0e-2_rp, 1.0e2_rp)
  call told('E falls', 'E_gradient', '', 0.0_rp, [-0.43_rp, -0.3667_rp, -0.30_rp], &
            'E falls toward the tip: 31 % lower than at the root, 26 to 35 %'//SURE)
  call told('E rises', 'E_gradient', '', 0.0_rp, [0.8_rp, 0.9_rp, 1.0_rp], &
            'E rises toward the tip: 2.5 times that at the root, 2.2 to 2.7 times'//SURE)
  call told('E perhaps falls', 'E_gradient', '', 0.0_rp, [-0.43_rp, -0.2_rp, 0.04_rp], &
            'Perhaps E falls toward the tip: from 35 % lower to 4 % higher than at the root'//SURE)
  call told('gain', 'force_gain', '', 1.0_rp, [1.227_rp, 1.249_rp, 1.272_rp], &
            'All forces were 25 % larger than declared, 23 to 27 %'//SURE)
  call told('a weak gain', 'force_gain', '', 1.0_rp, [0.78_rp, 0.801_rp, 0.82_rp], &
            'All forces were 19.9 % smaller than declared, 18.0 to 22.0 %'//SURE)
  call told('mass', 'point_mass', 'at (8.7, -0.9) mm', 0.0_rp, [3.024e-9_rp, 3.395e-9_rp, 3.794e-9_rp], &
            'Something sits on the wing at (8.7, -0.9) mm: 3.4 ug, 3.0 to 3.8 ug'//SURE)
  call told('thin veins', 'diameter_exponent', '', 4.0_rp, [3.1_rp, 3.2_rp, 3.3_rp], &
            'Thin veins are stiff against thick ones: one of half the diameter is 74 % stiffer than if both were solid and '// &
            'round, 62 to 87 %'//SURE)
  call told('a shift', 'load_shift_y', '', 0.0_rp, [-8.0e-5_rp, -6.0e-5_rp, -4.0e-5_rp], &
            'Forces acted beside the declared places: 60 um toward -y, 40 to 80 um'//SURE)
  call told('torsion', 'torsion', '', 0.0_rp, [0.031_rp, 0.036_rp, 0.041_rp], 'Veins resist being twisted: with 0.036 of '// &
            'their stiffness against bending (solid round veins: 0.77), 0.031 to 0.041'//SURE)
  call told('cuticle', 'cuticle', '', 0.0_rp, [1.1e-6_rp, 1.23e-6_rp, 1.35e-6_rp], &
            'Veins get stiffer the more they are bent: at a radius of 1 mm 2.23 times as stiff as when straight, '// &
            '2.10 to 2.35 times'//SURE)
  call told('pretension over 1 N/m in the file', 'pretension', '', 1.0_rp, [2.5_rp, 3.0_rp, 3.5_rp], &
            'The membrane is stretched when nothing pushes, by 3.0 N/m, 2.5 to 3.5 N/m'//SURE//PRESENT)
  call told('a clamp that is soft in the file', 'root_flap', '', 1.0e4_rp, [2.5e4_rp, 3.0e4_rp, 3.5e4_rp], &
            'The root gives way and lets the wing flap, by 1.7 degrees for every uN m of moment about y, 1.4 to 2.0 degrees'// &
            SURE//PRESENT)
  call told('a clamp that twists in the file', 'root_twist', '', 1.0e4_rp, [2.5e4_rp, 3.0e4_rp, 3.5e4_rp], &
            'The root gives way and lets the wing twist, by 1.7 degrees for every uN m of moment about x, 1.4 to 2.0 degrees'// &
            SURE//PRESENT)
  call ends()
  call t%finish()

contains

  !> One parameter above and below what was assumed, with an interval that excludes that.
  subroutine try(name, label, column)
    character(*), intent(in) :: name, label
    integer, intent(in) :: column
    real(rp), parameter :: STEP = 0.5_rp, WIDTH(3) = [0.8_rp, 1.0_rp, 1.3_rp]
    type(finding_t) :: finding
    type(wording_t) :: w
    character(:), allocatable :: text(:), one
    real(rp) :: most, shift
    integer :: i
    allocate (character(300) :: text(2))
    associate (q => catalogue%parameters(column))
      do i = 1, 2
        most = min(STEP*q%prior_sd, 0.5_rp*max(q%upper - q%null, q%null - q%lower))
        if (q%is_log) most = min(most, 0.3_rp)
        shift = merge(1, -1, i == 1)*most
        finding = make_finding(q, label, q%null + shift)
        w = find_wording(finding%name, finding%unit, finding%site, finding%null, finding%best)
        call t%check(name//': '//q%name//' has words of its own', w%is_known)
        finding%has_interval = .true.
        finding%has_lower = .true.
        finding%has_upper = .true.
        finding%lower = value_at(q%null + shift*WIDTH(merge(1, 3, i == 1)), q%is_log)
        finding%upper = value_at(q%null + shift*WIDTH(merge(3, 1, i == 1)), q%is_log)
        one = finding_text(finding)
        text(i) = one
        call t%check(one, index(one, SURE) > 0 .and. index(one, ' to ') > 0 .and. scan(one, '123456789') > 0)
        call t%check(name//': no number is written with a power of ten', index(one, 'E-') + index(one, 'E+') + index(one, '*') == 0)
      end do
      call t%check(name//': '//q%name//' tells plus from minus', text(1) /= text(2))
    end associate
  end subroutine try

  !> What is tried at many places lies between the bounds of the effect at each of them: factors, of which there are logarithms.
  subroutine bounded(name, lower, upper)
    character(*), intent(in) :: name
    real(rp), intent(in) :: lower, upper
    integer :: i, n
    logical :: is_right
    n = 0
    is_right = .true.
    do i = 1, size(catalogue%parameters)
      associate (q => catalogue%parameters(i))
        if (q%name /= name) cycle
        n = n + 1
        is_right = is_right .and. q%is_log .and. abs(q%lower - log(lower)) <= 0 .and. abs(q%upper - log(upper)) <= 0
      end associate
    end do
    call t%check(name//' has its bounds at all of its places', n > 1 .and. is_right)
  end subroutine bounded

  pure real(rp) function value_at(q, is_log)
    real(rp), intent(in) :: q
    logical, intent(in) :: is_log
    value_at = q
    if (is_log) value_at = exp(q)
  end function value_at

  subroutine told(sentence, name, site, null, ends, text)
    character(*), intent(in) :: sentence, name, site, text
    real(rp), intent(in) :: null, ends(3)
    call t%check(sentence//': '//finding_text(finding_of(name, site, null, ends)), &
                 finding_text(finding_of(name, site, null, ends)) == text)
  end subroutine told

  function finding_of(name, site, null, ends) result(finding)
    character(*), intent(in) :: name, site
    real(rp), intent(in) :: null, ends(3)
    type(finding_t) :: finding
    finding = finding_t(name=name, unit='1', site=site, null=null, best=ends(2), has_interval=.true., has_lower=.true., &
                        has_upper=.true., lower=ends(1), upper=ends(3))
  end function finding_of

  !> What the data do not determine is told without the value.
  subroutine ends()
    type(finding_t) :: finding
    finding = finding_of('E_gradient', '', 0.0_rp, [-0.43_rp, -0.3667_rp, -0.30_rp])
    finding%has_lower = .false.
    call t%check('one end: '//finding_text(finding), finding_text(finding) == &
                 'E falls toward the tip: at least 26 % lower than at the root with 95 % confidence')
    finding%has_lower = .true.
    finding%has_upper = .false.
    call t%check('the other end: '//finding_text(finding), finding_text(finding) == &
                 'Perhaps E falls toward the tip: at most 35 % lower than at the root with 95 % confidence')
    finding%has_lower = .false.
    call t%check('no end: '//finding_text(finding), finding_text(finding) == &
               'Perhaps E falls toward the tip: some amount lower than at the root (these data do not say how much)')
    finding%has_interval = .false.
    call t%check('not sought: '//finding_text(finding), finding_text(finding) == &
                 'E falls toward the tip: about 31 % lower than at the root')
  end subroutine ends

  !> Two forces at one place, up and down, held for different times, on a wing whose joints have sides; and, of another
  !> experiment, a mode.
  subroutine make()
    type(measurement_t) :: m
    type(solid_params_t) :: params
    type(static_options_t) :: options
    type(instrument_t) :: instrument
    type(failure_t) :: failure
    integer :: l
    m%x = [0.0_rp, 1.0_rp]
    m%y = [0.0_rp, 1.0_rp]
    allocate (m%loads(2), m%observations(0), m%zeros(0), m%modes(1))
    m%modes(1)%name = 'first'
    params = default_params(wing)
    params%effects%has_sides = .true.
    do l = 1, 2
      m%loads(l)%name = 'load'
      m%loads(l)%has_surface = .true.
      m%loads(l)%force = 1.0e-4_rp*l
      m%loads(l)%direction = [0.0_rp, 0.0_rp, 3.0_rp - 2*l]
      m%loads(l)%order = l
      m%loads(l)%time = 60*l
      m%loads(l)%hold = 10*l**2
      m%loads(l)%point = sum(wing%points(:2, wing%triangles(:, size(wing%triangles, 2)/2)), 2)/3
      allocate (m%loads(l)%node(2, 0), m%loads(l)%height(0), m%loads(l)%sigma(0))
    end do
    call instrument%set(NONLINEARITY, 0.0_rp)
    call bare%init(m, wing, params, [integer ::], options, failure, instrument, masses=spread(1.0e-9_rp, 1, size(wing%points, 2)))
    call t%check('the experiment is made',.not. failure%failed)
    call make_catalogue(bare, wing, [params%find('E')], 1.0_rp, catalogue)
  end subroutine make
end program test_diagnose_words
