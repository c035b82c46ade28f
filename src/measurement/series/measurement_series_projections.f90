! SPDX-License-Identifier: GPL-3.0-or-later
!> Projects sites, forces and masses onto the modes of a wing, given as shapes(3, n_all, modes).
module measurement_series_projections
  use base_kinds, only: rp
  use measurement_material_point, only: material_point_t
  use measurement_series, only: measured_series_t
  use solid_ringing, only: ring_change_t, EXCITED_BASE
  implicit none
  private
  public :: forcing_vector, inertia_along, no_change, no_matrix, observation_matrix, products, record_views

  real(rp), parameter, public :: ACROSS(3) = [0.0_rp, 0.0_rp, 1.0_rp] !< direction of a motion of the base that was not recorded

contains

  !> Returns the matrix of the products of a(:, :, i) and b(:, :, j).
  pure function products(a, b) result(c)
    real(rp), intent(in) :: a(:, :, :), b(:, :, :)
    real(rp) :: c(size(a, 3), size(b, 3))
    integer :: n
    n = size(a, 1)*size(a, 2)
    c = matmul(transpose(reshape(a, [n, size(a, 3)])), reshape(b, [n, size(b, 3)]))
  end function products

  !> Returns the displacements of a site along an axis.
  pure function displacement_along(site, axis, shapes) result(values)
    type(material_point_t), intent(in) :: site
    real(rp), intent(in) :: axis(3), shapes(:, :, :)
    real(rp) :: values(size(shapes, 3))
    integer :: c
    values = 0
    do c = 1, 3
      values = values + site%weight(c)*matmul(axis, shapes(:, site%corner(c), :))
    end do
  end function displacement_along

  !> Returns the products of the masses(3, n_all) [kg] that move along a direction.
  pure function inertia_along(mass, direction, shapes) result(values)
    real(rp), intent(in) :: mass(:, :), direction(3), shapes(:, :, :)
    real(rp) :: values(size(shapes, 3))
    integer :: i
    values = [(sum(direction*sum(mass*shapes(:, :, i), 2)), i=1, size(values))]
  end function inertia_along

  !> Returns shapes(3, n_all, modes) at the sites of the traces of a record along its axis.
  pure function observation_matrix(series, sites, shapes) result(observation)
    type(measured_series_t), intent(in) :: series
    type(material_point_t), intent(in) :: sites(:)
    real(rp), intent(in) :: shapes(:, :, :)
    real(rp) :: observation(size(series%sigma), size(shapes, 3))
    integer :: j
    do j = 1, size(observation, 1)
      observation(j, :) = displacement_along(sites(j), series%axis, shapes)
    end do
  end function observation_matrix

  !> Returns the declared excitation of a record on shapes(3, n_all, modes), for these masses(3, n_all) [kg]; see ringing_t.
  pure function forcing_vector(series, site, mass, shapes) result(forcing)
    type(measured_series_t), intent(in) :: series
    type(material_point_t), intent(in) :: site
    real(rp), intent(in) :: mass(:, :), shapes(:, :, :)
    real(rp) :: forcing(size(shapes, 3))
    if (series%excitation == EXCITED_BASE) then
      forcing = -inertia_along(mass, series%direction, shapes)
    else
      forcing = series%size*displacement_along(site, series%direction, shapes)
    end if
  end function forcing_vector

  !> Returns view(3, n_all, traces + 2), what a record sees of the modes: products of a shape with view(:, :, j) are its column of
  !> `observation_matrix`, its part of `forcing_vector`, and minus `inertia_along` ACROSS.
  pure function record_views(series, sites, excited_site, mass) result(view)
    type(measured_series_t), intent(in) :: series
    type(material_point_t), intent(in) :: sites(:), excited_site
    real(rp), intent(in) :: mass(:, :)
    real(rp) :: view(3, size(mass, 2), size(series%sigma) + 2)
    integer :: j, n
    n = size(series%sigma)
    view = 0
    do j = 1, n
      call add_point(sites(j), series%axis, view(:, :, j))
    end do
    if (series%excitation == EXCITED_BASE) then
      view(:, :, n + 1) = -spread(series%direction, 2, size(mass, 2))*mass
    else
      call add_point(excited_site, series%size*series%direction, view(:, :, n + 1))
    end if
    view(:, :, n + 2) = -spread(ACROSS, 2, size(mass, 2))*mass
  end function record_views

  !> Adds to view(3, n_all) what sees the displacement of a site along an axis.
  pure subroutine add_point(site, axis, view)
    type(material_point_t), intent(in) :: site
    real(rp), intent(in) :: axis(3)
    real(rp), intent(inout) :: view(:, :)
    integer :: c
    do c = 1, 3
      view(:, site%corner(c)) = view(:, site%corner(c)) + site%weight(c)*axis
    end do
  end subroutine add_point

  !> Returns a change by which nothing changes.
  pure function no_change() result(change)
    type(ring_change_t) :: change
    change%stiffness = no_matrix()
    change%mass = no_matrix()
    change%joints = no_matrix()
    change%observation = no_matrix()
    change%across = no_matrix()
    allocate (change%forcing(0), change%shaken(0))
  end function no_change

  !> Returns a matrix of size 0.
  pure function no_matrix() result(matrix)
    real(rp), allocatable :: matrix(:, :)
    allocate (matrix(0, 0))
  end function no_matrix
end module measurement_series_projections
