! SPDX-License-Identifier: GPL-3.0-or-later
!> Holds a buffer of complex numbers that is aligned for FFTW and grows to the largest need.
module spectral_buffer
  use, intrinsic :: iso_c_binding, only: c_null_ptr, c_ptr, c_size_t
  use base_kinds, only: rp
  use spectral_fftw, only: alloc_complex, free_buffer
  implicit none
  private
  public :: buffer_t

  type :: buffer_t
    complex(rp), pointer, contiguous :: data(:) => null()
    type(c_ptr), private :: handle = c_null_ptr
  contains
    procedure :: grow => buffer_grow
    procedure :: release => buffer_release
    procedure :: bytes => buffer_bytes
  end type buffer_t

contains

  !> Makes room for `words` numbers at least; their values are lost if it grows.
  subroutine buffer_grow(self, words)
    class(buffer_t), intent(inout) :: self
    integer(c_size_t), intent(in) :: words
    if (associated(self%data)) then
      if (size(self%data, kind=c_size_t) >= words) return
      call self%release()
    end if
    call alloc_complex(words, self%handle, self%data)
  end subroutine buffer_grow

  !> Releases the memory.
  subroutine buffer_release(self)
    class(buffer_t), intent(inout) :: self
    call free_buffer(self%handle)
    nullify (self%data)
  end subroutine buffer_release

  !> Returns the bytes of the buffer.
  pure real(rp) function buffer_bytes(self) result(bytes)
    class(buffer_t), intent(in) :: self
    bytes = 0
    if (associated(self%data)) bytes = 16*real(size(self%data, kind=c_size_t), rp)
  end function buffer_bytes
end module spectral_buffer
