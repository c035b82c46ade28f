! SPDX-License-Identifier: GPL-3.0-or-later
!> Random fields have the spectrum they were asked for, are solenoidal and real.
program test_random_field
  use base_constants, only: TWO_PI
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use support_fluid, only: make_fluid, box_3d, box_2d, NL
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  character(*), parameter :: CONDITION = '[InitialCondition]'//NL//'omega1=0.7'//NL//'inicond='
  integer :: unit

  call test%start(parallel=.true.)
  call check('3-D Rogallo field', box_3d(24, TWO_PI)//CONDITION//'turbulence_rogallo'//NL, 0.7_rp)
  call check('2-D Rogallo field', box_2d(24, TWO_PI)//CONDITION//'turbulence_rogallo'//NL, 0.7_rp)
  ! E(k) = 0.1 between k = 1 and 4: four shells of width 1.
  if (test%world%is_root) then
    open (newunit=unit, file='spectrum.txt', status='replace', action='write')
    write (unit, '(a)') '# k E', '0.5 0.1', '4.5 0.1'
    close (unit)
  end if
  call test%world%barrier()
  call check('given spectrum', box_3d(24, TWO_PI)//CONDITION//'random-given-spectrum'//NL// &
             'inicond_spectrum_file=spectrum.txt'//NL, 0.4_rp)
  call test%finish()

contains

  subroutine check(name, text, energy)
    character(*), intent(in) :: name, text
    real(rp), intent(in) :: energy
    type(fluid_t) :: fluid
    real(rp) :: sums(2), largest(1)
    integer :: z
    call make_fluid(test%world, text//'[MeanFlow]'//NL//'ux=0'//NL, fluid)
    sums = 0
    largest = 0
    do z = 1, fluid%transform%block%count(3)
      associate (flow => fluid%rhs%initial)
        call flow%bring(z)
        sums(1) = sums(1) + 0.5_rp*sum(flow%fields(:, :, z - flow%first, 1:3)**2)
        sums(2) = sums(2) + sum(flow%fields(:, :, z - flow%first, 1:3))
        largest = max(largest, maxval(abs(flow%fields(:, :, z - flow%first, 7))))
      end associate
    end do
    call test%world%sum_reals(sums)
    sums = sums/product(real(fluid%rhs%params%grid%n, rp))
    call test%world%max_reals(largest)
    call test%check_close(name//': mean energy', sums(1), energy, rtol=1e-12_rp)
    call test%check_below(name//': no mean velocity', abs(sums(2)), 1e-12_rp)
    call test%check_below(name//': no divergence', largest(1), 1e-12_rp)
    call check_shells(name, fluid)
    call fluid%free()
  end subroutine check

  !> Energy of each shell inside the truncation against the formula: k^4 exp(-k^2/2), scaled to 0.7 over the
  !> shells that the grid has, or 0.1.
  subroutine check_shells(name, fluid)
    character(*), intent(in) :: name
    type(fluid_t), intent(in) :: fluid
    integer, parameter :: SHELLS = 5
    real(rp) :: energy(SHELLS), want(SHELLS), scale
    integer :: s, i, shell
    energy = 0
    associate (t => fluid%transform%sticks, u => fluid%rhs%state%u)
      do s = 1, t%n
        do i = 1, t%nkz
          shell = nint(norm2([t%kx(s), t%ky(s), t%kz(i)]))
          if (shell < 1 .or. shell > SHELLS) cycle
          energy(shell) = energy(shell) + 0.5_rp*t%weight(s)*sum(abs(u(i, s, :))**2)
        end do
      end do
    end associate
    call test%world%sum_reals(energy)
    want = [0.1_rp, 0.1_rp, 0.1_rp, 0.1_rp, 0.0_rp]
    if (name /= 'given spectrum') then
      scale = 0.7_rp/sum([(real(i, rp)**4*exp(-real(i, rp)**2/2), i=1, 12)])
      want = [(scale*real(i, rp)**4*exp(-real(i, rp)**2/2), i=1, SHELLS)]
    end if
    call test%check_below(name//': energy of the shells', maxval(abs(energy - want)), 1e-9_rp)
  end subroutine check_shells
end program test_random_field
