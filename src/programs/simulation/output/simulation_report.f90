! SPDX-License-Identifier: GPL-3.0-or-later
!> Prints the reports at the start and at the end of a run.
module simulation_report
  use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
  use base_build, only: BUILD_VERSION, BUILD_COMMIT, BUILD_COMPILER
  use base_constants, only: PI
  use base_kinds, only: rp, i8
  use base_named_kinds, only: word_of
  use base_process, only: peak_memory
  use base_timers, only: timers_t
  use fluid_params, only: fluid_params_t, SCHEMES
  use fluid_solver, only: fluid_t
  use fluid_sponge_keys, only: SPONGES
  use fsi_body_keys, only: body_choices, body_choices_t
  use fsi_coupler, only: coupler_t
  use fsi_coupler_params, only: COUPLING_STRONG, COUPLING_WEAK
  use fsi_flapping_wings, only: flapping_wings_t
  use fsi_thin_wings, only: thin_wings_t
  use parallel_report, only: report_timers
  use parallel_world, only: world_t
  use simulation_settings, only: settings_t
  use solid_params, only: membrane_note
  use spectral_backends, only: TRANSFORMS, TRANSFORM_BUILTIN
  use spectral_fftw, only: PLAN_MEASURE
  use spectral_sticks, only: TRUNCATIONS
  implicit none
  private
  public :: print_coupling, print_failure, print_run_header, print_time_table, print_scales

contains

  !> Prints version, grid, ranks, memory and dimensionless numbers to `unit`. `restart_time` is absent in a new run. For root
  !> only.
  subroutine print_run_header(unit, settings, plans, fluid, restart_time, thin)
    integer, intent(in) :: unit
    type(settings_t), intent(in) :: settings
    character(*), intent(in) :: plans !< why FFTW measures or estimates its plans
    type(fluid_t), intent(in) :: fluid
    real(rp), intent(in), optional :: restart_time
    type(thin_wings_t), intent(in), optional :: thin !< wings without thickness
    real(rp) :: bytes
    bytes = fluid%memory_bytes()
    if (present(thin)) bytes = bytes + thin%memory_bytes()
    associate (p => settings%fluid, t => fluid%transform)
      write (unit, '(a)') 'flusi-msm '//BUILD_VERSION//' ('//BUILD_COMMIT//'), '//BUILD_COMPILER
      write (unit, '(a)') 'method: Engels, Kolomenskiy, Schneider & Sesterhenn 2016, DOI 10.1137/15M1026006'
      write (unit, '(a,3(i0,a),3(g0.4,a))') 'grid      ', p%grid%n(1), ' x ', p%grid%n(2), ' x ', p%grid%n(3), &
        ', box ', p%grid%length(1), ' x ', p%grid%length(2), ' x ', p%grid%length(3), ''
      write (unit, '(a,i0,a,i0,a,i0,5a,i0)') 'ranks     ', t%world%size, ' = ', t%rows, ' x ', t%columns, ', transform ', &
        word_of(TRANSFORMS, p%resolution%transform), ', truncation ', word_of(TRUNCATIONS, p%resolution%dealias), ', modes ', &
        int(t%sticks%rows%n, i8)*t%sticks%nkz
      write (unit, '(5a)') 'plans     ', merge('measured ', 'estimated', p%resolution%planner == PLAN_MEASURE), ', ', plans
      write (unit, '(a,f0.1,a)') 'memory    ', bytes/1.0e6_rp, ' MB per rank'
      call print_scales(unit, settings)
      if (present(thin)) call print_markers(unit, settings, thin)
      if (present(restart_time)) then
        write (unit, '(a,g0.6,a,i0)') 'restart   at t = ', restart_time, ', step ', fluid%rhs%state%step
        if (restart_time >= p%time%t_max .or. fluid%rhs%state%step >= p%time%nt) write (unit, '(a)') &
          '          this is the end of the run: to go on, increase [Time] Tmax, or nt if the input gives it'
      else
        write (unit, '(a,a)') 'start     ', p%initial%word
      end if
      write (unit, '(a,g0.6,a)', advance='no') 'end       t = ', p%time%t_max, ', '
      if (p%time%has_nt) write (unit, '(a,i0,a)', advance='no') 'or step ', p%time%nt, ', '
      write (unit, '(a)') word_of(SCHEMES, p%time%scheme)
    end associate
    flush (unit)
  end subroutine print_run_header

  !> Prints how markers cover the wings without thickness, and the vanishing viscosity of their flow.
  subroutine print_markers(unit, settings, thin)
    integer, intent(in) :: unit
    type(settings_t), intent(in) :: settings
    type(thin_wings_t), intent(in) :: thin
    integer :: i
    do i = 1, size(thin%wings)
      associate (m => thin%wings(i)%markers)
        write (unit, '(a,i0,2(a,f0.2),a)') 'surface   '//trim(settings%flight%wings(i)%side)//': no thickness, ', m%n, &
          ' markers, nearest ', m%least, ', largest gap ', m%gap, ' of their spacing'
      end associate
    end do
    write (unit, '(2(a,f0.2),a)') '          spacing ', settings%flight%thin%spacing/settings%fluid%grid%max_spacing(), &
      ' cells; vanishing viscosity damps the largest wavenumber at ', settings%fluid%vanishing_rate, ' per T'
  end subroutine print_markers

  !> Prints the Reynolds number and the numbers of penalization and sponge, and with [units] the SI value of each unit. For root
  !> only.
  subroutine print_scales(unit, settings)
    integer, intent(in) :: unit
    type(settings_t), intent(in) :: settings
    real(rp) :: speed, h
    associate (p => settings%fluid, u => settings%units)
      h = p%grid%max_spacing()
      speed = norm2(p%mean%velocity)
      write (unit, '(a,g0.6)') 'viscosity ', p%nu
      if (p%nu > 0 .and. speed > 0 .and. p%solids%size > 0) &
        write (unit, '(a,g0.5,a)') 'Reynolds  Re = |u_mean| Size / nu = ', speed*p%solids%size/p%nu, ''
      if (p%solids%is_on) write (unit, '(a,es9.2,a,f0.3,a)') 'solid     '//p%solids%mask_word()//', C_eta =', p%solids%c_eta, &
        ', K_eta = sqrt(nu C_eta)/dx = ', sqrt(p%nu*p%solids%c_eta)/h, ' (0.1 to 0.5 resolves the penalization layer)'
      if (p%sponge%is_on) write (unit, '(a,es9.2,a,i0,a)') 'sponge    '//word_of(SPONGES, p%sponge%kind)//', C_sp =', &
        p%sponge%damping_time, ', ', &
        p%sponge%thickness, ' points'
      if (p%solids%is_moving) call print_flight(unit, settings)
      if (.not. u%given) return
      write (unit, '(3(a,g0.5))') 'units     L = ', u%length, ' m, 1/T = ', u%frequency, ' 1/s, density ', u%density
      write (unit, '(3(a,g0.5),a)') '          velocity ', u%length*u%frequency, ' m/s, force ', &
        u%density*u%length**4*u%frequency**2, ' N, power ', u%density*u%length**5*u%frequency**3, ' W'
    end associate
  end subroutine print_scales

  !> Prints the wings, their motion and the numbers by which flights are compared.
  subroutine print_flight(unit, settings)
    integer, intent(in) :: unit
    type(settings_t), intent(in) :: settings
    type(body_choices_t) :: body
    real(rp) :: r, f, chord, tip, wind, low, high
    integer :: i
    body = body_choices(settings%config)
    associate (solid => settings%flight%solid)
      if (solid%exists()) write (unit, '(a,g0.5,a,3(1x,f0.4))') 'body      '//body%type//': volume in the mask ', &
        solid%displaced%mass, ' L^3, size', solid%high - solid%low
    end associate
    if (size(settings%flight%wings) == 0) return
    associate (flight => settings%flight, p => settings%fluid, u => settings%units)
      r = flight%wings(1)%length()
      f = flight%frequency()
      chord = flight%wings(1)%mean_chord()
      tip = flight%tip_speed()
      wind = norm2(p%mean%velocity)
      do i = 1, size(flight%wings)
        associate (wing => flight%wings(i))
          call wing%motion%stroke_extremes(low, high)
          write (unit, '(a,i0,a,2(f0.4,a),f0.2,a)') 'wing      '//trim(wing%side)//': ', size(wing%triangles, 2), &
            ' triangles, R = ', wing%length(), ', mean chord ', wing%mean_chord(), ', stroke ', (high - low)*180/PI, &
            ' degrees'
        end associate
      end do
      write (unit, '(3(a,g0.5),a)') '          f = ', f, ', mean tip speed = ', tip, ', u_inf = ', wind
      if (p%nu > 0) write (unit, '(a,f0.1,a)') 'Reynolds  Re = (u_tip + u_inf) chord / nu = ', (tip + wind)*chord/p%nu, ''
      if (tip > 0) write (unit, '(a,f0.3)') '          advance ratio u_inf/u_tip = ', wind/tip
      if (.not. flight%thin%is_thin) write (unit, '(2(a,f0.2),a)') 'thickness ', &
        2*flight%half_thickness/p%grid%max_spacing(), ' cells, smoothing ', &
        flight%smoothing/p%grid%max_spacing(), ' cells'
      write (unit, '(2(a,g0.5))', advance='no') 'scales    rho R^4 f^2 = ', r**4*f**2, ', rho R^5 f^3 = ', r**5*f**3
      if (u%given) write (unit, '(4(a,g0.5),a)', advance='no') '; R = ', 1.0e3_rp*r*u%length, ' mm, f = ', &
        f*u%frequency, ' 1/s, force ', 1.0e3_rp*u%density*(r*u%length)**4*(f*u%frequency)**2, ' mN, power ', &
        1.0e3_rp*u%density*(r*u%length)**5*(f*u%frequency)**3, ' mW'
      write (unit, '(a)') ''
    end associate
    if (settings%flexible) call print_bending(unit, settings)
  end subroutine print_flight

  !> Prints the material of wings that bend, and whether their coupling is safe (docs/theory/coupling.md).
  subroutine print_bending(unit, settings)
    integer, intent(in) :: unit
    type(settings_t), intent(in) :: settings
    real(rp), parameter :: UG = 1.0e9_rp, G = 1.0e3_rp
    character(:), allocatable :: note
    real(rp) :: air, chord, stiffness
    logical :: is_soft
    associate (wing => settings%flight%wings(1), c => settings%coupler, p => settings%fluid)
      chord = merge(wing%length(), wing%mean_chord(), p%grid%is_2d)*c%units%length
      air = settings%units%density*PI/4*chord
      write (unit, '(a,i0,a,es10.3,a,f0.1,a,f0.2,a,f0.2,a)') 'bending   ', c%model%n_points, ' points, E = ', &
        c%model%params%young, ' Pa, mass ', UG*sum(c%inertia%mass), ' ug, membrane ', G*c%membrane, &
        ' g/m^2, fluid that it accelerates ', G*air, ' g/m^2'
      call membrane_note(c%model%params, note, is_soft)
      if (c%membrane > 0 .and. c%density > settings%units%density) then
        write (unit, '(a,f0.2,a)') '          '//note//'; the membrane''s mass means ', &
          1.0e6_rp*c%membrane/c%density, ' um'
      else
        write (unit, '(a)') '          '//note
      end if
      write (unit, '(a)') '          +z of [Wing] is the '//trim(merge('dorsal ', 'ventral', &
        (wing%mount%dorsal_sign() > 0) .neqv. wing%is_mirrored))//' side of all wings'
      write (unit, '(a,f0.2)') '          largest added-mass ratio over the wing ', c%added_mass
      stiffness = 0
      if (c%light_layer > 0) stiffness = 2*settings%flight%half_thickness*c%units%length*settings%units%density/ &
                                         c%light_layer*step_over_c_eta(p)
      if (settings%flight%thin%is_thin) return ! the step of the wing includes the reaction of the flow
      if (c%added_mass > 1) write (unit, '(a)') '          the wing is lighter than the fluid that it moves: '// &
        advice(c%coupling)
      if (stiffness > c%stability_limit()) write (unit, '(2(a,f0.2),a)') &
        '          (dt/C_eta) rho t/(mass per area of the lightest tenth) = ', stiffness, ' may exceed ', &
        c%stability_limit(), &
        ': the coupling may be unstable; better: coupling = strong, a smaller dt_max or a thinner sheet'
    end associate
  end subroutine print_bending

  !> Returns what a large added mass means for a coupling.
  pure function advice(coupling) result(text)
    integer, intent(in) :: coupling
    character(:), allocatable :: text
    select case (coupling)
    case (COUPLING_WEAK)
      text = 'with weak coupling the load lags behind the motion by a step; '// &
             'set coupling = strong, or extrapolated where it is stable'
    case (COUPLING_STRONG)
      text = 'strong coupling is stable here; the lighter the wing, the more evaluations of the flow a step needs'
    case default
      text = 'compare with coupling = strong'
    end select
  end function advice

  !> Returns the largest dt/C_eta that the parameters allow.
  pure real(rp) function step_over_c_eta(p) result(ratio)
    type(fluid_params_t), intent(in) :: p
    if (p%time%dt_fixed > 0) then
      ratio = p%time%dt_fixed/p%solids%c_eta
    else
      ratio = p%time%cfl_eta
      if (p%time%dt_max > 0) ratio = min(ratio, p%time%dt_max/p%solids%c_eta)
    end if
  end function step_over_c_eta

  !> Prints how much work the sub-iterations of a strong coupling took; it prints nothing for other couplings. For root only.
  subroutine print_coupling(unit, coupler)
    integer, intent(in) :: unit
    type(coupler_t), intent(in) :: coupler
    associate (report => coupler%report)
      if (coupler%params%coupling /= COUPLING_STRONG .or. report%steps == 0) return
      write (unit, '(a,f0.2,a)') 'the strong coupling took ', real(report%total, rp)/report%steps, &
        ' '//trim(merge('passes of the wings    ', 'evaluations of the flow', coupler%is_thin))// &
        ' per step, counted under bending wings'
    end associate
  end subroutine print_coupling

  !> Prints how the time of the run was spent, over all ranks. Root prints. Collective.
  subroutine print_time_table(world, timers, whole, fluid, wings)
    type(world_t), intent(in) :: world
    type(timers_t), intent(in) :: timers
    integer, intent(in) :: whole !< region that covers the run
    type(fluid_t), intent(in) :: fluid
    type(flapping_wings_t), intent(in), optional :: wings
    real(rp) :: exchange(1), peak(1), busy(1), sums(2)
    integer(i8) :: bytes, messages
    call report_timers(world, timers, whole, output_unit)
    exchange(1) = fluid%transform%traffic%seconds
    call world%max_reals(exchange)
    bytes = world%sum_int8(fluid%transform%traffic%bytes)
    messages = world%sum_int8(fluid%transform%traffic%messages)
    if (world%is_root .and. fluid%rhs%params%resolution%transform == TRANSFORM_BUILTIN) &
      write (output_unit, '(a,f0.2,a,f0.3,a,i0,a)') 'of the time steps, exchanges between ranks took at most ', &
      exchange(1), ' s on a rank: ', real(bytes, rp)/1.0e9_rp, ' GB in ', messages, ' messages'
    peak = real(peak_memory(), rp)/1.0e6_rp
    call world%max_reals(peak)
    if (world%is_root .and. peak(1) > 0) write (output_unit, '(a,f0.1,a)') 'memory    ', peak(1), &
      ' MB at most on a rank, programs and libraries included'
    if (.not. present(wings)) return
    busy = wings%seconds
    call world%max_reals(busy)
    sums = [wings%seconds, wings%cells]
    call world%sum_reals(sums)
    if (sums(2) <= 0) return ! the mask has no moving solid
    if (world%is_root) write (output_unit, '(2(a,f0.2),a)') 'drawing the wings took at most ', busy(1), &
      ' s on a rank, ', 1.0e9_rp*sums(1)/max(1.0_rp, sums(2)), ' ns per cell of the band around them'
  end subroutine print_time_table

  !> Prints on standard error why a run has failed, and which files it leaves for that case. For root only.
  subroutine print_failure(reason, has_diverged, has_backup)
    character(*), intent(in) :: reason
    logical, intent(in) :: has_diverged   !< the velocity has grown without bound or is not a number
    logical, intent(in) :: has_backup !< there is a backup from which a run can continue
    write (error_unit, '(a)') 'flusi: '//reason
    if (has_diverged) write (error_unit, '(a)') 'flusi: the failing velocity is in failed-u*.h5'
    if (has_backup) write (error_unit, '(a)') 'flusi: the last valid backup is kept'
    flush (error_unit)
  end subroutine print_failure
end module simulation_report
