! SPDX-License-Identifier: GPL-3.0-or-later
!> Flapping wings across the boundaries of blocks: the same flow and loads on all ranks together, on every process
!> grid, and on one rank alone, there with the builtin transform; with both time steppers.
!>
!> usage: test_flapping_ranks [builtin|p3dfft]
program test_flapping_ranks
  use base_kinds, only: rp
  use fluid_solver, only: fluid_t
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_wing_loads, only: wing_loads, wing_loads_t
  use mpi_f08, only: MPI_COMM_SELF
  use parallel_world, only: world_t
  use support_wings, only: make_wings, NL, run_wings, wings_text, write_lines
  use test_pick, only: asked_transform
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: kit

  call kit%start(parallel=.true.)
  call write_lines(kit%world, 'wing.ini', '[Wing]'//NL//'type=ellipse'//NL//'root=0.05'//NL//'length=0.75'//NL// &
                   'mean_chord=0.3'//NL//'front=0.3')
  call write_lines(kit%world, 'beat.ini', '[kinematics]'//NL//'type=fourier'//NL//'units=degree'//NL// &
                   'nfft_phi=1'//NL//'a0_phi=20.0'//NL//'ai_phi=55.0'//NL//'bi_phi=8.0'//NL// &
                   'nfft_alpha=2'//NL//'a0_alpha=-10.0'//NL//'ai_alpha=0.0 4.0'//NL//'bi_alpha=45.0 -6.0'//NL// &
                   'nfft_theta=1'//NL//'a0_theta=6.0'//NL//'ai_theta=3.0'//NL//'bi_theta=-9.0')
  call compare('AB2')
  call compare('RK4')
  call kit%finish()

contains

  subroutine compare(scheme)
    character(*), intent(in) :: scheme
    type(fluid_t) :: alone, together
    type(flapping_wings_t) :: wings_alone, wings_together
    type(world_t) :: self
    character(40) :: detail
    character(:), allocatable :: ini
    real(rp) :: difference
    integer :: rows
    ini = wings_text()//'eta0=-50'//NL//'yawpitchroll_0=15.0 10.0 -20.0'//NL//'Jxx=0.003'//NL// &
          'FlappingMotion_left=from_file::beat.ini'//NL//'FlappingMotion_right=from_file::beat.ini'//NL// &
          'wing_ramp=0.1'//NL//'wing_frequency=1.3'//NL// &
          '[Time]'//NL//'Tmax=0.06'//NL//'dt_max=0.005'//NL//'iTimeMethodFluid='//scheme//NL// &
     '[MeanFlow]'//NL//'iMeanFlow_x=fixed'//NL//'iMeanFlow_y=free'//NL//'iMeanFlow_z=free'//NL//'ux=0.5'//NL//'uy=0'// &
       NL//'uz=0'//NL//'[Sponge]'//NL//'iVorticitySponge=yes'//NL//'iSpongeType=outlet_x'//NL//'eps_sponge=0.05'//NL// &
          'sponge_thickness=4'//NL
    call self%adopt(MPI_COMM_SELF)
    call make_wings(self, ini, alone, wings_alone)
    call run_wings(alone, wings_alone)
    call kit%check(scheme//': a good number of steps is made', alone%rhs%state%step > 10)
    do rows = 1, kit%world%size
      if (mod(kit%world%size, rows) /= 0) cycle
      write (detail, '(a,i0)') '[Resolution]'//NL//'process_rows=', rows
      call make_wings(kit%world, ini//trim(detail)//NL//'[Parallel]'//NL//'transform='//asked_transform()//NL, together, &
                      wings_together)
      call run_wings(together, wings_together)
      associate (b => together%transform%block)
        difference = maxval(abs(together%rhs%fields - &
                                alone%rhs%fields(:, b%start(2) + 1:b%start(2) + b%count(2), &
                                                 b%start(3) + 1:b%start(3) + b%count(3), :)))
      end associate
      ! The largest number is a vorticity: fields are compared to it.
      call kit%check_below(scheme//': same fields', difference, 1.0e-12_rp*maxval(abs(alone%rhs%fields)))
      call kit%check(scheme//': same steps', together%rhs%state%step == alone%rhs%state%step)
      call kit%check(scheme//': the wings are spread over the ranks', kit%world%size == 1 .or. &
                     wings_together%mask%n_cells < wings_alone%mask%n_cells)
      call same_loads(scheme, wings_alone, alone, wings_together, together)
      call together%free()
    end do
    call alone%free()
  end subroutine compare

  subroutine same_loads(scheme, wings_a, a, wings_b, b)
    character(*), intent(in) :: scheme
    type(flapping_wings_t), intent(in) :: wings_a, wings_b
    type(fluid_t), intent(in) :: a, b
    type(wing_loads_t) :: one, two
    integer :: i
    do i = 1, 2
      one = wing_loads(wings_a, i, a)
      two = wing_loads(wings_b, i, b)
      call kit%check_below(scheme//': same force', norm2(one%force - two%force), 1.0e-12_rp*norm2(one%force))
      call kit%check_below(scheme//': same torque', norm2(one%torque - two%torque), 1.0e-12_rp*norm2(one%torque))
      call kit%check_below(scheme//': same power', abs(one%power - two%power), 1.0e-12_rp*abs(one%power))
      call kit%check_below(scheme//': the wings are in the same place, to the bit', &
                           maxval(abs(wings_a%surfaces(i)%points - wings_b%surfaces(i)%points)), 0.0_rp)
      call kit%check_below(scheme//': with the same unsteady loads, to the bit', &
                       maxval(abs([one%unsteady_force - two%unsteady_force, one%unsteady_torque - two%unsteady_torque, &
                                       one%unsteady_power - two%unsteady_power, &
                                       one%inertial_power - two%inertial_power])), 0.0_rp)
    end do
  end subroutine same_loads
end program test_flapping_ranks
