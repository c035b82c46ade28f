! SPDX-License-Identifier: GPL-3.0-or-later
!> The same flow on all ranks together, on every process grid, and on one rank alone; there always with the builtin
!> transform.
!>
!> usage: test_rank_independence [builtin|p3dfft]
program test_rank_independence
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use mpi_f08, only: MPI_COMM_SELF
  use parallel_world, only: world_t
  use support_fluid, only: make_fluid, run_to_end, NL
  use test_pick, only: asked_transform
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test

  call test%start(parallel=.true.)
  call compare('sphere with sponge', '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=sphere'//NL//'eps=0.02'//NL// &
               '[Sponge]'//NL//'iVorticitySponge=yes'//NL//'iSpongeType=cavity'//NL//'eps_sponge=0.1'//NL// &
               'sponge_thickness=4'//NL, 24, 'MeanFlow')
  call compare('dynamic mean flow in a cavity', '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=cylinder'//NL// &
               'iCavity=yes'//NL//'cavity_size=2'//NL//'eps=0.02'//NL, 18, 'VortexRing')
  call compare('2-D cylinder', '[Penalization]'//NL//'iPenalization=1'//NL//'iMask=cylinder_x'//NL//'eps=0.02'//NL, 1, &
               'MeanFlow')
  call compare('random field', '', 16, 'turbulence_rogallo')
  call test%finish()

contains

  subroutine compare(name, text, nx, inicond)
    character(*), intent(in) :: name, text, inicond
    integer, intent(in) :: nx
    type(fluid_t) :: alone, together
    type(world_t) :: self
    character(40) :: grid, detail
    character(:), allocatable :: ini
    real(rp) :: difference
    integer :: rows
    write (grid, '(a,i0,a)') '[Resolution]'//NL//'nx=', nx, NL//'ny=20'//NL//'nz=18'//NL
  ini = trim(grid)//'[Geometry]'//NL//'xl=2.4'//NL//'yl=2.0'//NL//'zl=1.8'//NL//'Size=0.6'//NL//'[InitialCondition]'// &
      NL//'inicond='//inicond//NL//'omega1=1.0'//NL//'[ReynoldsNumber]'//NL//'nu=0.02'//NL//'[Time]'//NL//'Tmax=0.3'// &
          NL//'CFL=0.3'//NL//'[MeanFlow]'//NL//'ux=1.0'//NL//'uy=0.5'//NL//'uz=0.2'//NL//'iMeanFlow_x=dynamic'//NL// &
          'm_fluid=5.0'//NL//text
    call self%adopt(MPI_COMM_SELF)
    call make_fluid(self, ini, alone)
    call run_to_end(alone)
    do rows = 1, test%world%size
      if (mod(test%world%size, rows) /= 0) cycle
      ! P3DFFT gives every rank of a row its own kx, of which a flow in the plane has one.
      if (asked_transform() == 'p3dfft' .and. nx == 1 .and. rows > 1) cycle
      write (detail, '(a,i0)') NL//'[Resolution]'//NL//'process_rows=', rows
      call make_fluid(test%world, ini//trim(detail)//NL//'[Parallel]'//NL//'transform='//asked_transform()//NL, together)
      call run_to_end(together)
      associate (b => together%transform%block)
        difference = maxval(abs(together%rhs%fields - &
                                alone%rhs%fields(:, b%start(2) + 1:b%start(2) + b%count(2), &
                                                 b%start(3) + 1:b%start(3) + b%count(3), :)))
      end associate
      write (detail, '(a,i0)') ', rows ', rows
      call test%check_below(name//': same fields'//trim(detail), difference, 1e-12_rp)
      ! Forces are differences of sums over the solid; their scale is that of the largest one.
      call test%check_below(name//': same forces'//trim(detail), maxval(abs(together%sums%force - alone%sums%force)), &
                            1e-12_rp*max(1.0_rp, maxval(abs(alone%sums%force))))
      call test%check_close(name//': same energy'//trim(detail), sum(together%sums%energy), sum(alone%sums%energy), &
                            rtol=1e-13_rp)
      call test%check_below(name//': same moments'//trim(detail), &
                            maxval(abs(together%sums%moment - alone%sums%moment)), &
                            1e-12_rp*max(1.0_rp, maxval(abs(alone%sums%moment))))
      call test%check(name//': same steps'//trim(detail), together%rhs%state%step == alone%rhs%state%step)
      call together%free()
    end do
    call alone%free()
  end subroutine compare
end program test_rank_independence
