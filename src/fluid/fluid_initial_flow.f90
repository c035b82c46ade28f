! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds the untruncated flow that a run begins with, until its first step has been made and written.
!>
!> Only the full spectrum of the velocity is stored, three numbers per point. The fields that the first pass multiplies are
!> computed from it on demand, for one part of the planes at a time.
module fluid_initial_flow
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_memory, only: check_allocation, REAL_BYTES
  use fluid_flow_fields, only: flow_field, VORTICITY_MAGNITUDE
  use fluid_initial, only: initial_velocity
  use fluid_kernels, only: stick_fields, stick_curl, stick_divergence
  use fluid_params, only: fluid_params_t
  use fluid_state, only: allocate_spectra
  use parallel_block, only: split_evenly
  use spectral_backends, only: make_full_transform
  use spectral_sticks, only: sticks_t
  use spectral_transform, only: kernels_t, transform_t
  implicit none
  private
  public :: initial_flow_t, MOST_PARTS

  integer, parameter :: MOST_PARTS = 12 !< each costs one more transform in z of all fields, once in a run

  type, extends(kernels_t) :: initial_flow_t
    real(rp), allocatable :: fields(:, :, :, :) !< (nx, ny_local, planes, 7) velocity, vorticity, divergence of the planes
    integer :: first = 0                        !< number of planes before these; `bring` changes it
    integer, private :: last = 0, part = 0, parts = 1, n_planes = 0
    class(transform_t), allocatable, private :: full
    type(sticks_t), private :: sticks           !< of `full`
    complex(rp), allocatable, private :: u(:, :, :) !< (nkz, sticks, 3)
  contains
    procedure :: begin => initial_begin
    procedure :: bring => initial_bring
    procedure :: field => initial_field
    procedure :: rest => initial_rest
    procedure :: free => initial_free
    procedure :: spectral_in => initial_spectral_in
    procedure :: product => initial_product
    procedure :: spectral_out => initial_spectral_out
    procedure, private :: load
  end type initial_flow_t

contains

  !> Makes the flow at t = 0 over the points of `main`. Fails if a file cannot be read. If the transform knows no parts, all
  !> fields are made at once, and `main` can be used again at once. Collective.
  subroutine initial_begin(self, main, params, time, failure)
    class(initial_flow_t), intent(inout) :: self
    class(transform_t), intent(in) :: main
    type(fluid_params_t), intent(in) :: params
    real(rp), intent(out) :: time !< when the run starts: 0, or the time of the files
    type(failure_t), intent(inout) :: failure
    call make_full_transform(main, self%full)
    self%sticks = self%full%sticks
    self%n_planes = main%block%count(3)
    call allocate_spectra(self%u, self%sticks, 'the initial condition')
    call initial_velocity(self%full, params, self%u, time, failure)
    self%parts = min(MOST_PARTS, self%full%most_parts())
    if (failure%failed) then
      call self%free()
    else if (self%parts == 1) then
      call self%load(1)
      call self%free()
    else
      call self%full%release()
    end if
  end subroutine initial_begin

  !> Fills `fields` for the part that contains the local plane `z`. Every pass begins with plane 1 and proceeds to the last plane.
  !> Collective where a part begins.
  subroutine initial_bring(self, z)
    class(initial_flow_t), intent(inout) :: self
    integer, intent(in) :: z
    if (z > self%first .and. z <= self%last) return
    call self%load(merge(1, self%part + 1, z == 1))
  end subroutine initial_bring

  !> Computes the fields of a part of the planes. Collective.
  subroutine load(self, part)
    class(initial_flow_t), intent(inout) :: self
    integer, intent(in) :: part
    class(transform_t), allocatable :: full
    integer :: most, none, status
    call split_evenly(self%n_planes, self%parts, 0, none, most)
    associate (n => self%full%block%count)
      status = 0
      if (.not. allocated(self%fields)) allocate (self%fields(n(1), n(2), most, 7), stat=status)
      call check_allocation(status, [n(1), n(2), most, 7], REAL_BYTES, 'the initial condition in space')
    end associate
    self%part = part
    call split_evenly(self%n_planes, self%parts, part - 1, self%first, most)
    self%last = self%first + most
    self%n_in = 7
    self%curl = 6
    call move_alloc(self%full, full) ! it calls procedures of `self`
    call full%to_points_part(self, part, self%parts)
    call move_alloc(full, self%full)
  end subroutine load

  !> Computes one field (nx, ny_local, nz_local, 1), numbered as in `flow_field`. Collective.
  subroutine initial_field(self, which, field)
    class(initial_flow_t), intent(inout) :: self
    integer, intent(in) :: which
    real(rp), contiguous, target, intent(inout) :: field(:, :, :, :)
    if (self%parts > 1) then
      call flow_field(self%full, self%u, which, self%parts, field)
    else if (which == VORTICITY_MAGNITUDE) then
      field(:, :, :, 1) = sqrt(self%fields(:, :, :, 4)**2 + self%fields(:, :, :, 5)**2 + self%fields(:, :, :, 6)**2)
    else
      field(:, :, :, 1) = self%fields(:, :, :, which)
    end if
  end subroutine initial_field

  !> Releases the memory that only a pass needs.
  subroutine initial_rest(self)
    class(initial_flow_t), intent(inout) :: self
    if (self%parts == 1) return
    call self%full%release()
    if (allocated(self%fields)) deallocate (self%fields)
    self%first = 0
    self%last = 0
  end subroutine initial_rest

  !> Releases the full transform. Collective.
  subroutine initial_free(self)
    class(initial_flow_t), intent(inout) :: self
    if (allocated(self%full)) call self%full%free()
    if (allocated(self%full)) deallocate (self%full)
    if (allocated(self%u)) deallocate (self%u)
  end subroutine initial_free

  !> Fills `fields` with velocity and vorticity of these sticks; see kernels_t.
  subroutine initial_spectral_in(self, first, count, fields)
    class(initial_flow_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    integer :: i, s
    do i = 1, count
      s = first + i - 1
      associate (t => self%sticks, u => self%u, f => fields)
        call stick_fields(t%nkz, t%kx(s), t%ky(s), t%kz, u(:, s, 1), u(:, s, 2), u(:, s, 3), f(:, i, 1), f(:, i, 2), &
                          f(:, i, 3), f(:, i, 4), f(:, i, 5))
        if (self%fill_curl) call stick_curl(t%nkz, t%kx(s), t%ky(s), u(:, s, 1), u(:, s, 2), f(:, i, 6))
        call stick_divergence(t%nkz, t%kx(s), t%ky(s), t%kz, u(:, s, 1), u(:, s, 2), u(:, s, 3), f(:, i, 7))
      end associate
    end do
  end subroutine initial_spectral_in

  !> Stores the fields on the lines of this batch; see kernels_t.
  subroutine initial_product(self, first, count, z, in, out)
    class(initial_flow_t), intent(inout) :: self
    integer, intent(in) :: first, count, z
    real(rp), contiguous, intent(in) :: in(:, :, :)
    real(rp), contiguous, intent(inout) :: out(:, :, :)
    self%fields(:, first:first + count - 1, z - self%first, :) = in(:, 1:count, :)
    associate (nothing_to_transform => out)
    end associate
  end subroutine initial_product

  !> Does nothing, since nothing is transformed forward; see kernels_t.
  subroutine initial_spectral_out(self, first, count, fields)
    class(initial_flow_t), intent(inout) :: self
    integer, intent(in) :: first, count
    complex(rp), contiguous, intent(inout) :: fields(:, :, :)
    associate (nothing_comes => self, there => first, is => count, here => fields)
    end associate
  end subroutine initial_spectral_out
end module fluid_initial_flow
