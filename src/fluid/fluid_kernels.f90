! SPDX-License-Identifier: GPL-3.0-or-later
!> The inner loops of the fluid: plain arrays in, plain arrays out, no state.
!>
!> A stick is a line of modes (kx, ky, all kz); a line is a row of grid points in x.
module fluid_kernels
  use base_kinds, only: rp
  implicit none
  private
  public :: stick_fields, stick_curl, stick_divergence, line_product, project_stick, add_sponge, ab2_stick, weighted_sum, &
            add_weighted, biot_savart

contains

  !> Copies one stick of u, and computes the vorticity i k x u along x and y on it.
  pure subroutine stick_fields(nkz, kx, ky, kz, u, v, w, u_out, v_out, w_out, omega_x, omega_y)
    integer, intent(in) :: nkz
    real(rp), intent(in) :: kx, ky, kz(nkz)
    complex(rp), intent(in) :: u(nkz), v(nkz), w(nkz)
    complex(rp), intent(inout) :: u_out(nkz), v_out(nkz), w_out(nkz), omega_x(nkz), omega_y(nkz)
    integer :: i
    do i = 1, nkz
      u_out(i) = u(i)
      v_out(i) = v(i)
      w_out(i) = w(i)
      omega_x(i) = times_i(ky*w(i) - kz(i)*v(i))
      omega_y(i) = times_i(kz(i)*u(i) - kx*w(i))
    end do
  end subroutine stick_fields

  !> Computes the vorticity along z on one stick.
  pure subroutine stick_curl(nkz, kx, ky, u, v, omega_z)
    integer, intent(in) :: nkz
    real(rp), intent(in) :: kx, ky
    complex(rp), intent(in) :: u(nkz), v(nkz)
    complex(rp), intent(inout) :: omega_z(nkz)
    integer :: i
    do i = 1, nkz
      omega_z(i) = times_i(kx*v(i) - ky*u(i))
    end do
  end subroutine stick_curl

  !> Computes i k . u on one stick.
  pure subroutine stick_divergence(nkz, kx, ky, kz, u, v, w, divergence)
    integer, intent(in) :: nkz
    real(rp), intent(in) :: kx, ky, kz(nkz)
    complex(rp), intent(in) :: u(nkz), v(nkz), w(nkz)
    complex(rp), intent(inout) :: divergence(nkz)
    integer :: i
    do i = 1, nkz
      divergence(i) = times_i(kx*u(i) + ky*v(i) + kz(i)*w(i))
    end do
  end subroutine stick_divergence

  !> Returns i a without a complex multiplication.
  elemental complex(rp) function times_i(a) result(b)
    complex(rp), intent(in) :: a
    b = cmplx(-aimag(a), real(a), rp)
  end function times_i

  !> Computes N = u x omega on one line, the largest |u|^2, and the sum of |u|^2 per x.
  pure subroutine line_product(n, u, v, w, a, b, c, out1, out2, out3, q_max, q_sum)
    integer, intent(in) :: n
    real(rp), intent(in) :: u(n), v(n), w(n), a(n), b(n), c(n)
    real(rp), intent(inout) :: out1(n), out2(n), out3(n), q_max(n), q_sum(n)
    real(rp) :: q
    integer :: x
    do x = 1, n
      out1(x) = v(x)*c(x) - w(x)*b(x)
      out2(x) = w(x)*a(x) - u(x)*c(x)
      out3(x) = u(x)*b(x) - v(x)*a(x)
      q = u(x)*u(x) + v(x)*v(x) + w(x)*w(x)
      q_max(x) = merge(q, q_max(x), q > q_max(x))
      q_sum(x) = q_sum(x) + q
    end do
  end subroutine line_product

  !> Replaces N by N - k (k.N)/k^2 and computes the total pressure -i k.N/k^2 on one stick. The mean stays as it is.
  pure subroutine project_stick(nkz, kx, ky, kz, n1, n2, n3, pressure)
    integer, intent(in) :: nkz
    real(rp), intent(in) :: kx, ky, kz(nkz)
    complex(rp), intent(inout) :: n1(nkz), n2(nkz), n3(nkz), pressure(nkz)
    complex(rp) :: c
    integer :: i
    do i = 1, nkz
      c = (kx*n1(i) + ky*n2(i) + kz(i)*n3(i))/max(kx*kx + ky*ky + kz(i)*kz(i), tiny(1.0_rp))
      n1(i) = n1(i) - kx*c
      n2(i) = n2(i) - ky*c
      n3(i) = n3(i) - kz(i)*c
      pressure(i) = -times_i(c)
    end do
  end subroutine project_stick

  !> Adds the velocity term i k x q/k^2 of the damped vorticity q to N on one stick; nothing for k = 0.
  pure subroutine add_sponge(nkz, kx, ky, kz, q1, q2, q3, n1, n2, n3)
    integer, intent(in) :: nkz
    real(rp), intent(in) :: kx, ky, kz(nkz)
    complex(rp), intent(in) :: q1(nkz), q2(nkz), q3(nkz)
    complex(rp), intent(inout) :: n1(nkz), n2(nkz), n3(nkz)
    real(rp) :: inverse
    integer :: i
    do i = 1, nkz
      inverse = 1/max(kx*kx + ky*ky + kz(i)*kz(i), tiny(1.0_rp))
      n1(i) = n1(i) + inverse*times_i(ky*q3(i) - kz(i)*q2(i))
      n2(i) = n2(i) + inverse*times_i(kz(i)*q1(i) - kx*q3(i))
      n3(i) = n3(i) + inverse*times_i(kx*q2(i) - ky*q1(i))
    end do
  end subroutine add_sponge

  !> Updates one component by AB2 on one stick: u = E (u + b10 N + b11 H), then H = E N.
  pure subroutine ab2_stick(nkz, factor, along, b10, b11, n, u, h)
    integer, intent(in) :: nkz
    real(rp), intent(in) :: factor, along(nkz), b10, b11 !< E = factor*along
    complex(rp), intent(in) :: n(nkz)
    complex(rp), intent(inout) :: u(nkz), h(nkz)
    real(rp) :: e
    integer :: i
    do i = 1, nkz
      e = factor*along(i)
      u(i) = e*(u(i) + b10*n(i) + b11*h(i))
      h(i) = e*n(i)
    end do
  end subroutine ab2_stick

  !> Computes out = factor_a along_a a + weight factor_b along_b b on one stick, the building block of the Runge-Kutta stages.
  pure subroutine weighted_sum(nkz, factor_a, along_a, a, weight, factor_b, along_b, b, out)
    integer, intent(in) :: nkz
    real(rp), intent(in) :: factor_a, along_a(nkz), weight, factor_b, along_b(nkz)
    complex(rp), intent(in) :: a(nkz), b(nkz)
    complex(rp), intent(inout) :: out(nkz)
    integer :: i
    do i = 1, nkz
      out(i) = factor_a*along_a(i)*a(i) + weight*factor_b*along_b(i)*b(i)
    end do
  end subroutine weighted_sum

  !> Adds weight factor along a to `out` on one stick.
  pure subroutine add_weighted(nkz, weight, factor, along, a, out)
    integer, intent(in) :: nkz
    real(rp), intent(in) :: weight, factor, along(nkz)
    complex(rp), intent(in) :: a(nkz)
    complex(rp), intent(inout) :: out(nkz)
    integer :: i
    do i = 1, nkz
      out(i) = out(i) + weight*factor*along(i)*a(i)
    end do
  end subroutine add_weighted

  !> Computes the velocity i k x omega/k^2 of a vorticity on one stick, without a mean.
  pure subroutine biot_savart(nkz, kx, ky, kz, omega_x, omega_y, omega_z, u, v, w)
    integer, intent(in) :: nkz
    real(rp), intent(in) :: kx, ky, kz(nkz)
    complex(rp), intent(in) :: omega_x(nkz), omega_y(nkz), omega_z(nkz)
    complex(rp), intent(inout) :: u(nkz), v(nkz), w(nkz)
    u = 0
    v = 0
    w = 0
    call add_sponge(nkz, kx, ky, kz, omega_x, omega_y, omega_z, u, v, w)
  end subroutine biot_savart
end module fluid_kernels
