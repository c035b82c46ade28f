! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimates the memory that a rank needs, before anything is allocated.
module simulation_memory
  use base_kinds, only: rp
  use fluid_initial, only: is_uniform
  use fluid_initial_flow, only: MOST_PARTS
  use fluid_params, only: fluid_params_t, SCHEME_RK4
  use simulation_settings, only: settings_t
  use spectral_backends, only: TRANSFORM_P3DFFT
  use spectral_sticks, only: sticks_t, kept_columns, make_block_sticks, make_sticks, process_grid
  implicit none
  private
  public :: memory_t, estimate_memory

  !> Holds the estimated memory of the rank that needs the largest amount, and how the ranks share the grid.
  type :: memory_t
    logical :: possible = .false.    !< the grid can be divided among this number of ranks
    integer :: rows = 1, columns = 1
    real(rp) :: running = 0          !< bytes at most while stepping, writing and backing up
    real(rp) :: starting = 0         !< bytes at most until the first step has been written
    real(rp) :: largest_buffer = 0   !< length of the largest exchange buffer: complex words, or bytes for P3DFFT
  end type memory_t

  !> Holds the sizes in bytes of the part of one field or spectrum that a rank holds.
  type :: portion_t
    real(rp) :: field = 0    !< a field on its points
    real(rp) :: spectrum = 0 !< a field on its modes inside the truncation
    real(rp) :: exchange = 0 !< exchange buffers of a field
    real(rp) :: planes = 1   !< number of its planes
    real(rp) :: whole = 0, whole_exchange = 0 !< the same of a spectrum without truncation
  end type portion_t

  integer, parameter :: FIELDS_IN = 7 !< velocity, vorticity, divergence

contains

  !> Returns the largest memory that any of `ranks` ranks needs. It leaves out wings and their markers, whose memory does not grow
  !> with the grid. No rank waits for another.
  function estimate_memory(settings, ranks) result(m)
    type(settings_t), intent(in) :: settings
    integer, intent(in) :: ranks
    type(memory_t) :: m
    type(portion_t) :: s
    real(rp) :: kept, flow, writing
    integer :: n_out, n_sent, parts
    associate (p => settings%fluid, o => settings%output)
      n_out = merge(6, 3, p%sponge%is_on) + merge(1, 0, settings%needs_pressure())
      if (p%resolution%transform == TRANSFORM_P3DFFT) then
        call blocks_portion(p, ranks, m, s)
      else
        call sticks_portion(p, ranks, m, s)
      end if
      if (.not. m%possible) return
      n_sent = merge(FIELDS_IN - 1, FIELDS_IN, m%rows == 1) ! the vorticity along z is computed from the velocity
      ! The state, its history, and the fields that are kept from a pass.
      kept = s%spectrum*merge(9, 6, p%time%scheme == SCHEME_RK4)
      if (settings%needs_pressure()) kept = kept + s%spectrum
      if (settings%needs_trials()) kept = kept + 3*s%spectrum
      if (settings%needs_fields()) kept = kept + 6*s%field
      if (settings%samples_pressure() .or. o%fields%wing_sides) kept = kept + s%field
      kept = kept + o%held_fields(p%grid%n(1))*s%field
      flow = merge(3, 0, o%needs_flow())*s%spectrum
      ! One field and its copy of single precision; a component of the state as a table and its copy.
      writing = merge(1, 0, o%needs_scratch())*s%field
      writing = writing + max(merge(0.5_rp, 0.0_rp, o%fields%single_precision .and. o%needs_scratch())*s%field, 2*s%spectrum)
      if (p%resolution%transform == TRANSFORM_P3DFFT) then
        m%running = kept + flow + writing + s%exchange + (s%spectrum + s%field)*(FIELDS_IN + n_out)
        m%starting = m%running
        if (.not. is_uniform(p)) m%starting = m%running + FIELDS_IN*s%field + 8*s%whole
        return
      end if
      m%running = kept + flow + writing + s%exchange*max(n_sent, n_out)
      m%starting = m%running
      if (is_uniform(p)) return
      ! The whole spectrum stays until the first step has been written, by parts of the planes.
      parts = min(MOST_PARTS, p%grid%n(3)/m%columns)
      if (parts == 1) then
        m%starting = kept + s%exchange*n_out + FIELDS_IN*s%field + max(writing, 3*s%whole + n_sent*s%whole_exchange)
      else
        m%starting = max(m%running, 3*s%whole + max(kept + s%exchange*n_out + max((n_sent*s%whole_exchange + FIELDS_IN*s%field)* &
                                        ceiling(s%planes/parts)/s%planes, writing + s%whole_exchange/parts), &
                                                    kept + s%exchange + s%whole_exchange + s%field))
      end if
    end associate
  end function estimate_memory

  !> Computes the shares of the builtin transform; see spectral_pencil for the two exchange buffers.
  subroutine sticks_portion(p, ranks, m, s)
    type(fluid_params_t), intent(in) :: p
    integer, intent(in) :: ranks
    type(memory_t), intent(inout) :: m
    type(portion_t), intent(out) :: s
    type(sticks_t) :: sticks
    real(rp) :: lines, row_sticks, near, far
    call process_grid(ranks, p%grid%n, p%resolution%process_rows, m%rows, m%columns, m%possible)
    if (.not. m%possible) return
    associate (n => p%grid%n)
      sticks = make_sticks(p%grid, p%resolution%dealias, m%rows, m%columns, 0, 0)
      s%planes = ceiling(n(3)/real(m%columns, rp))
      lines = ceiling(n(2)/real(m%rows, rp))
      s%field = 8*n(1)*lines*s%planes
      s%spectrum = 16*real(sticks%n, rp)*sticks%nkz
      near = 0
      if (m%columns > 1) near = real(sticks%n, rp)*n(3)
      if (m%rows > 1) near = max(near, real(sticks%n_row_kx, rp)*n(2)*s%planes)
      far = sticks%n_row_sticks*s%planes
      if (m%rows > 1) far = max(far, sticks%n_jx*lines*s%planes)
      s%exchange = 16*(near + far)
      m%largest_buffer = FIELDS_IN*max(near, far)
      ! Without truncation all columns kx have a stick for each ky.
      row_sticks = ceiling((n(1)/2 + 1)/real(m%rows, rp))*real(n(2), rp)
      s%whole = 16*ceiling(row_sticks/m%columns)*real(n(3), rp)
      near = 0
      if (max(m%rows, m%columns) > 1) near = max(s%whole/16, row_sticks*s%planes)
      far = row_sticks*s%planes
      if (m%rows > 1) far = max(far, (n(1)/2 + 1)*lines*s%planes)
      s%whole_exchange = 16*(near + far)
      m%largest_buffer = max(m%largest_buffer, near, far)
    end associate
  end subroutine sticks_portion

  !> Computes the shares of P3DFFT. The rank with the lowest modes has the most sticks.
  subroutine blocks_portion(p, ranks, m, s)
    type(fluid_params_t), intent(in) :: p
    integer, intent(in) :: ranks
    type(memory_t), intent(inout) :: m
    type(portion_t), intent(out) :: s
    type(sticks_t) :: sticks
    integer :: block(2)
    real(rp) :: lines, box
    block = [kept_columns(p%grid, p%resolution%dealias), p%grid%n(2)]
    call process_grid(ranks, p%grid%n, p%resolution%process_rows, m%rows, m%columns, m%possible, block)
    if (.not. m%possible) return
    block = ceiling(block/real([m%rows, m%columns], rp))
    sticks = make_block_sticks(p%grid, p%resolution%dealias, [0, 0], block)
    s%planes = ceiling(p%grid%n(3)/real(m%columns, rp))
    lines = ceiling(p%grid%n(2)/real(m%rows, rp))
    s%field = 8*p%grid%n(1)*lines*s%planes
    s%spectrum = 16*real(sticks%n, rp)*sticks%nkz
    box = product(real(block, rp))*p%grid%n(3)
    s%whole = 16*(p%grid%n(1)/2 + 1)*lines*s%planes
    s%exchange = 16*box + 3*max(16*box, s%whole)
    m%largest_buffer = 16*box
  end subroutine blocks_portion
end module simulation_memory
