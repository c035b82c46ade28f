! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes measurement files for tests: a small valid one, of which any part can be replaced by something else.
module measurement_writer
  use base_kinds, only: rp
  use wing_writer, only: wing_writer_t
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  implicit none
  private
  public :: measurement_writer_t, unloaded_heights, loaded_heights

  integer, parameter, public :: NX = 4, NY = 3
  real(rp), parameter, public :: MM = 1.0e-3_rp, X(NX) = MM*[-0.5_rp, 0.5_rp, 1.5_rp, 2.5_rp], &
                                 Y(NY) = MM*[0.2_rp, 1.0_rp, 1.8_rp]
  real(rp), parameter :: UP(3) = [0.0_rp, 0.0_rp, 2.0_rp]

  type, extends(wing_writer_t) :: measurement_writer_t
  contains
    procedure :: measurement
    procedure :: load
    procedure :: observation
  end type measurement_writer_t

contains

  !> A valid measurement of the sample wing, which is a plate of 2 mm by 2 mm: load tip with heights, load base with the
  !> readings turn and move.
  subroutine measurement(self, path)
    class(measurement_writer_t), intent(inout) :: self
    character(*), intent(in) :: path
    call self%sample(path)
    call self%delete('/points')
    call self%delete('/triangles')
    call self%delete('/veins')
    call self%delete('/joints')
    call self%delete('/root')
    call self%delete_attribute('/', 'index_base')
    call self%text_attribute('/', 'schema', 'flusi-msm measurement')
    call self%group('/reference')
    call self%reals('/reference/x', [NX], X)
    call self%reals('/reference/y', [NY], Y)
    call self%reals('/reference/z', [NX, NY], unloaded_heights())
    call self%group('/accuracy')
    call self%real_attribute('/accuracy', 'height', [3.0e-6_rp])
    call self%real_attribute('/accuracy', 'force_gain', [0.02_rp])
    call self%group('/calibration')
    call self%integer_attribute('/calibration', 'order_is_random', 1)
    call self%text_attribute('/calibration', 'by', 'somebody')
    call self%group('/loads')
    call self%load('tip', [1.5_rp*MM, 1.0_rp*MM])
    call self%reals('/loads/tip/z', [NX, NY], loaded_heights())
    call self%integer_attribute('/loads/tip', 'order', 2)
    call self%integer_attribute('/loads/tip', 'replicate', 3)
    call self%real_attribute('/loads/tip', 'time', [60.0_rp])
    call self%real_attribute('/loads/tip', 'hold', [5.0_rp])
    call self%load('base', [0.5_rp*MM, 1.0_rp*MM])
    call self%group('/points')
    call self%observation('turn', 'rotation', 'rad')
    call self%observation('move', 'displacement', 'm')
    call self%group('/extra')
  end subroutine measurement

  subroutine load(self, name, point)
    class(measurement_writer_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(in) :: point(2)
    call self%group('/loads/'//name)
    call self%real_attribute('/loads/'//name, 'force', [1.0e-3_rp])
    call self%real_attribute('/loads/'//name, 'direction', UP)
    call self%real_attribute('/loads/'//name, 'point', point)
  end subroutine load

  subroutine observation(self, name, quantity, units)
    class(measurement_writer_t), intent(inout) :: self
    character(*), intent(in) :: name, quantity, units
    call self%group('/points/'//name)
    call self%variable_text_attribute('/points/'//name, 'load', 'base')
    call self%text_attribute('/points/'//name, 'quantity', quantity)
    call self%text_attribute('/points/'//name, 'units', units)
    call self%real_attribute('/points/'//name, 'point', [1.0_rp*MM, 1.2_rp*MM])
    call self%real_attribute('/points/'//name, 'axis', [0.0_rp, 1.0_rp, 0.0_rp])
    call self%integer_attribute('/points/'//name, 'value', 0)
    call self%real_attribute('/points/'//name, 'sigma', [1.0e-4_rp])
    call self%text_attribute('/points/'//name, 'zero', 'first')
  end subroutine observation

  !> [m], row by row; the second is missing.
  function unloaded_heights() result(z)
    real(rp) :: z(NX*NY)
    z = 1.0e-5_rp
    z(2) = ieee_value(z(2), ieee_quiet_nan)
  end function unloaded_heights

  !> [m]; the third is missing.
  function loaded_heights() result(z)
    real(rp) :: z(NX*NY)
    z = 1.1e-4_rp
    z(3) = ieee_value(z(3), ieee_quiet_nan)
  end function loaded_heights
end module measurement_writer
