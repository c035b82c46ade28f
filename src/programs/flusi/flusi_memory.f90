! SPDX-License-Identifier: GPL-3.0-or-later
!> What a rank needs in memory, before anything is allocated.
module flusi_memory
  use base_kinds, only: rp
  use fluid_params, only: fluid_params_t, SCHEME_RK4
  use spectral_sticks, only: sticks_t, kept_columns, make_block_sticks, make_sticks, process_grid
  implicit none
  private
  public :: memory_t, estimate_memory

  type :: memory_t
    logical :: possible = .false.    !< whether the grid can be shared among so many ranks
    integer :: rows = 1, columns = 1
    real(rp) :: running = 0          !< bytes while stepping: state, exchange buffers, kept fields
    real(rp) :: starting = 0         !< bytes at most while the initial condition is made
    real(rp) :: largest_buffer = 0   !< what is counted of the largest exchange buffer: complex words, P3DFFT's bytes
  end type memory_t

contains

  !> The largest need of any of `ranks` ranks.
  function estimate_memory(p, keeps_fields, keeps_pressure, keeps_rhs, couples, makes_fields, ranks, held_fields) result(m)
    type(fluid_params_t), intent(in) :: p
    logical, intent(in) :: keeps_fields, keeps_pressure, keeps_rhs
    logical, intent(in) :: couples !< flexible wings, which look at the pressure
    logical, intent(in) :: makes_fields !< any field is written that is not one of those kept
    integer, intent(in) :: ranks
    real(rp), intent(in) :: held_fields !< by the output, one is as large as a component of the velocity
    type(memory_t) :: m
    type(sticks_t) :: s
    real(rp) :: sticks, planes, lines, points, buffers, full, state, box
    integer :: n_out, block(2)
    logical :: in_blocks
    in_blocks = p%transform == 'p3dfft'
    if (in_blocks) then
      block = [kept_columns(p%grid, p%dealias), p%grid%n(2)]
      call process_grid(ranks, p%grid%n, p%process_rows, m%rows, m%columns, m%possible, block)
    else
      call process_grid(ranks, p%grid%n, p%process_rows, m%rows, m%columns, m%possible)
    end if
    if (.not. m%possible) return
    if (in_blocks) then
      ! The rank with the lowest modes has most sticks.
      block = ceiling(block/real([m%rows, m%columns], rp))
      s = make_block_sticks(p%grid, p%dealias, [0, 0], block)
    else
      s = make_sticks(p%grid, p%dealias, m%rows, m%columns, 0, 0)
    end if
    n_out = merge(6, 3, p%sponge) + merge(1, 0, keeps_pressure)
    sticks = s%n
    planes = ceiling(p%grid%n(3)/real(m%columns, rp))
    lines = ceiling(p%grid%n(2)/real(m%rows, rp))
    points = p%grid%n(1)*lines*planes
    state = 16*sticks*s%nkz*merge(9, 6, p%scheme == SCHEME_RK4)
    if (in_blocks) then
      box = product(real(block, rp))*p%grid%n(3)
      buffers = 16*box + 48*max(box, (p%grid%n(1)/2 + 1)*lines*planes) + (16*sticks*s%nkz + 8*points)*(7 + n_out)
      m%largest_buffer = 16*box
    else
      buffers = 16*s%n_row_sticks*planes*(7 + n_out)
      m%largest_buffer = s%n_row_sticks*planes*7
      if (m%columns > 1) then
        buffers = buffers + 16*sticks*p%grid%n(3)*7
        m%largest_buffer = max(m%largest_buffer, sticks*p%grid%n(3)*7)
      end if
      if (m%rows > 1) then
        buffers = buffers + 16*planes*(s%n_jx*lines*(7 + n_out) + real(s%n_row_kx, rp)*p%grid%n(2)*7)
        m%largest_buffer = max(m%largest_buffer, planes*real(s%n_row_kx, rp)*p%grid%n(2)*7)
      end if
    end if
    m%running = state + buffers
    if (keeps_fields) m%running = m%running + 8*points*6
    if (keeps_fields .or. keeps_pressure .or. makes_fields) m%running = m%running + 8*points ! scratch to write one field
    if (keeps_pressure) m%running = m%running + 16*sticks*s%nkz
    if (couples) m%running = m%running + 8*points
    m%running = m%running + 8*points*held_fields
    if (keeps_rhs) m%running = m%running + 16*sticks*s%nkz*3
    ! The initial condition: its untruncated spectrum (three fields and one more) with the buffers of one
    ! field, and the seven physical fields that the first step begins from.
    full = (p%grid%n(1)/2 + 1)*real(p%grid%n(2), rp)*p%grid%n(3)/ranks
    if (in_blocks) then
      m%starting = m%running + 8*points*7 + 16*(p%grid%n(1)/2 + 1)*lines*planes*8
      return
    end if
    m%largest_buffer = max(m%largest_buffer, full)
    m%starting = m%running + 8*points*7 + 16*full*(4 + merge(2, 3, m%columns == 1)*merge(1, 2, m%rows == 1))
  end function estimate_memory
end module flusi_memory
