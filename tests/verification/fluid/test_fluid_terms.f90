! SPDX-License-Identifier: GPL-3.0-or-later
!> Single terms against closed forms or against a second computation: pressure, sponge, swinging mean
!> flow, forces and moments, volumes of drawn bodies.
program test_fluid_terms
  use base_constants, only: PI, TWO_PI
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use fluid_fields, only: mask_field, solid_velocity_field
  use fluid_requests, only: request_t
  use fluid_solver, only: fluid_t
  use io_fields, only: field_form_t, field_meta_t, write_field
  use support_fluid, only: make_fluid, run_to_end, box_2d, box_3d, NL
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: test
  character(*), parameter :: AT_REST = '[MeanFlow]'//NL//'ux=0'//NL//'uy=0'//NL//'uz=0'//NL

  call test%start(parallel=.true.)
  call pressure_of_vortices()
  call sponge_damps()
  call mean_flow_swings()
  call forces_twice()
  call volumes()
  call test%finish()

contains

  !> p = (cos 2y + cos 2z - 1)/4 exp(-4 nu t) for 2-D Taylor-Green; its mean is -<|u|^2>/2 by definition.
  subroutine pressure_of_vortices()
    type(fluid_t) :: fluid
    type(request_t) :: request
    type(failure_t) :: failure
    real(rp), allocatable :: p(:, :, :, :)
    real(rp) :: worst(1), y, z, decay
    integer :: iy, iz
    call make_fluid(test%world, box_2d(32, TWO_PI)//'[InitialCondition]'//NL//'inicond=taylor_green_2d'//NL// &
                    '[ReynoldsNumber]'//NL//'nu=0.05'//NL//'[Time]'//NL//'Tmax=0.5'//NL//AT_REST, fluid)
    call run_to_end(fluid)
    request%fields = .true.
    request%pressure = .true.
    call fluid%evaluate(request, failure)
    associate (b => fluid%transform%block)
      allocate (p(b%count(1), b%count(2), b%count(3), 1))
      call fluid%pressure_field(p)
      decay = exp(-4*0.05_rp*0.5_rp)
      worst = 0
      do iz = 1, b%count(3)
        do iy = 1, b%count(2)
          y = TWO_PI*(iy - 1 + b%start(2))/32
          z = TWO_PI*(iz - 1 + b%start(3))/32
          worst(1) = max(worst(1), abs(p(1, iy, iz, 1) - decay*(cos(2*y) + cos(2*z) - 1)/4))
        end do
      end do
    end associate
    call test%world%max_reals(worst)
    call test%check_below('the pressure of Taylor-Green vortices', worst(1), 1e-12_rp)
    call fluid%free()
  end subroutine pressure_of_vortices

  !> The step that the rule allows must damp as a step of a quarter does: second order in dt/C_sp, which is
  !> 1/2, leaves some per cent of the energy that the sponge takes.
  subroutine sponge_damps()
    real(rp) :: free, rule, fine
    free = energy_with('')
    rule = energy_with('[Sponge]'//NL//'iVorticitySponge=yes'//NL//'iSpongeType=cavity'//NL//'eps_sponge=0.01'// &
                       NL//'sponge_thickness=6'//NL)
    fine = energy_with('[Sponge]'//NL//'iVorticitySponge=yes'//NL//'iSpongeType=cavity'//NL//'eps_sponge=0.01'// &
                       NL//'sponge_thickness=6'//NL//'[Time]'//NL//'dt_max=0.00125'//NL)
    call test%check('the sponge takes most of the energy', rule < 0.3_rp*free)
    call test%check_close('and the largest allowed step damps as a small one', rule, fine, rtol=0.05_rp)
  end subroutine sponge_damps

  real(rp) function energy_with(sponge) result(energy)
    character(*), intent(in) :: sponge
    type(fluid_t) :: fluid
    call make_fluid(test%world, box_3d(24, TWO_PI)//'[InitialCondition]'//NL//'inicond=turbulence_rogallo'//NL// &
                    'omega1=0.01'//NL//'[ReynoldsNumber]'//NL//'nu=0.001'//NL//'[Time]'//NL//'Tmax=0.2'//NL// &
                    'CFL=0.5'//NL//AT_REST//sponge, fluid)
    call run_to_end(fluid)
    energy = sum(fluid%sums%energy)
    call fluid%free()
  end function energy_with

  !> From rest the CFL rule alone would step over the whole swing.
  subroutine mean_flow_swings()
    type(fluid_t) :: fluid
    call make_fluid(test%world, box_3d(16, TWO_PI)//'[InitialCondition]'//NL//'inicond=quiescent'//NL//'[Time]'// &
                    NL//'Tmax=0.6'//NL//'CFL=1.0'//NL//'[MeanFlow]'//NL//'ux=2.0'//NL//'uy=0'//NL//'uz=0'//NL// &
                    'iMeanFlow_x=sinusoidal'//NL//'umean_freq=1.0'//NL, fluid)
    call run_to_end(fluid)
    call test%check_close('the mean flow is U sin(2 pi f t)', fluid%sums%mean(1), 2*sin(TWO_PI*0.6_rp), atol=1e-12_rp)
    call test%check('and is followed by 50 steps per period', fluid%rhs%state%step >= 30)
    call fluid%free()
  end subroutine mean_flow_swings

  !> Forces, moments and power again from dense fields and lever arms.
  subroutine forces_twice()
    type(fluid_t) :: fluid
    real(rp), allocatable :: chi(:, :, :), us(:, :, :, :)
    real(rp) :: f(3), r(3), sums(7), slip(3)
    integer :: x, y, z, c
    call make_fluid(test%world, '[Resolution]'//NL//'nx=20'//NL//'ny=18'//NL//'nz=24'//NL//'[Geometry]'//NL// &
                    'xl=2.0'//NL//'yl=1.8'//NL//'zl=2.4'//NL//'Size=0.9'//NL//'alpha=30'//NL//'x0=0.7'//NL// &
                    '[InitialCondition]'//NL//'inicond=MeanFlow'//NL//'[Time]'//NL//'Tmax=0.2'//NL//'CFL=0.3'//NL// &
                    '[MeanFlow]'//NL//'ux=1'//NL//'uy=0.4'//NL//'uz=-0.3'//NL//'[Penalization]'//NL// &
                    'iPenalization=1'//NL//'iMask=plate'//NL//'eps=0.02'//NL//'us_fixed=0.1 0.2 -0.3'//NL, fluid)
    call run_to_end(fluid)
    associate (b => fluid%transform%block, g => fluid%rhs%params%grid, u => fluid%rhs%fields)
      allocate (chi(b%count(1), b%count(2), b%count(3)), us(b%count(1), b%count(2), b%count(3), 3))
      call mask_field(fluid%rhs%penalty, chi)
      do c = 1, 3
        call solid_velocity_field(fluid%rhs%penalty, c, us(:, :, :, c))
      end do
      sums = 0
      do z = 1, b%count(3)
        do y = 1, b%count(2)
          do x = 1, b%count(1)
            if (chi(x, y, z) <= 0) cycle
            r = ([x, y, z] - 1 + b%start)*g%spacing - fluid%rhs%params%solids%centre
            slip = u(x, y, z, 1:3) - us(x, y, z, :)
            f = chi(x, y, z)/0.02_rp*slip*g%cell_volume()
            sums = sums + [f, r(2)*f(3) - r(3)*f(2), r(3)*f(1) - r(1)*f(3), r(1)*f(2) - r(2)*f(1), &
                           -dot_product(us(x, y, z, :), f)]
          end do
        end do
      end do
      call test%world%sum_reals(sums)
    end associate
    call test%check_below('forces from dense fields', maxval(abs(fluid%sums%force(:, 1) - sums(1:3))), 1e-13_rp)
    call test%check_below('moments from dense fields', maxval(abs(fluid%sums%moment(:, 1) - sums(4:6))), 1e-13_rp)
    call test%check_close('power from dense fields', sum(fluid%sums%power), sums(7), atol=1e-13_rp)
    call test%check('the oblique plate feels a moment', abs(fluid%sums%moment(3, 1)) > 1e-3_rp)
    call fluid%free()
  end subroutine forces_twice

  !> Volumes of bodies. The profile is odd about the surface, so that a plane face is exact. On a sphere
  !> curvature adds 8 pi R h^2 m to its volume, m = int s (chi - step) ds/h^2 = 1/2 - 4/pi^2, relative
  !> 6 m (h/R)^2 (the sum over grid points adds 1e-4); on the edges of a plate at most 2 h^2 per length differ.
  subroutine volumes()
    type(field_meta_t) :: meta
    type(failure_t) :: failure
    type(fluid_t) :: fluid
    real(rp), allocatable :: chi(:, :, :)
    real(rp) :: middle, corner, h
    h = 1.5_rp*2/40
    middle = volume_of(box_3d(40, 2.0_rp)//'Size=1.0'//NL, 'sphere')
    corner = volume_of(box_3d(40, 2.0_rp)//'Size=1.0'//NL//'x0=0'//NL//'y0=1.95'//NL//'z0=0.05'//NL, 'sphere')
    call test%check_close('volume of a sphere', middle, PI/6*(1 + 6*(0.5_rp - 4/PI**2)*(h/0.5_rp)**2), rtol=3e-4_rp)
    call test%check_close('a sphere across the corner of the box is whole', corner, middle, rtol=1e-12_rp)
    call test%check_close('volume of a square plate', &
                          volume_of(box_3d(40, 2.0_rp)//'Size=1.0'//NL//'alpha=30'//NL, 'plate'), 4*2.0_rp/40, &
                          rtol=4*2*h**2/(4*2.0_rp/40))
    call test%check_close('area of a plate in 2-D', &
                          volume_of(box_2d(40, 2.0_rp)//'Size=1.0'//NL//'alpha=30'//NL, 'plate'), 4*2.0_rp/40, &
                          rtol=2*2*h**2/(4*2.0_rp/40))
    ! A mask that is written and read again.
    call make_fluid(test%world, solid(box_3d(40, 2.0_rp)//'Size=1.0'//NL, 'sphere'), fluid)
    associate (b => fluid%transform%block)
      allocate (chi(b%count(1), b%count(2), b%count(3)))
      call mask_field(fluid%rhs%penalty, chi)
      meta%domain_size = 2
      call write_field(test%world, 'drawn', b, chi, meta, field_form_t('.', '000000'), failure)
    end associate
    call fluid%free()
    call test%check_close('a mask from a file', volume_of(box_3d(40, 2.0_rp), 'from_file::drawn_000000.h5'), middle, &
                          rtol=1e-14_rp)
  end subroutine volumes

  real(rp) function volume_of(box, body) result(volume)
    character(*), intent(in) :: box, body
    type(fluid_t) :: fluid
    type(request_t) :: request
    type(failure_t) :: failure
    call make_fluid(test%world, solid(box, body), fluid)
    request%integrals = .true.
    call fluid%evaluate(request, failure)
    volume = fluid%sums%solid_volume(1)
    call fluid%free()
  end function volume_of

  function solid(box, body) result(text)
    character(*), intent(in) :: box, body
    character(:), allocatable :: text
    text = box//'[InitialCondition]'//NL//'inicond=quiescent'//NL//'[Penalization]'//NL//'iPenalization=1'//NL// &
           'iMask='//body//NL//AT_REST
  end function solid
end program test_fluid_terms
