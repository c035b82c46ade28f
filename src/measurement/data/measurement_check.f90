! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks a measurement before it is compared with a wing.
module measurement_check
  use base_constants, only: PI
  use base_kinds, only: rp
  use base_magnitude, only: rounded
  use base_text, only: number_text
  use measurement_data, only: measurement_t
  use measurement_modes, only: check_modes
  use measurement_series, only: check_series
  use measurement_material_point, only: find_material_point, material_point_t, NEAR
  use measurement_sampling, only: outline_edges, sample_surface, surface_sample_t
  use solid_wing, only: wing_t
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: check_measurement

  real(rp), parameter :: MOST_SCALE = 30        !< extent of the grid over that of the wing, or the reverse
  real(rp), parameter :: MOST_DEFORMATION = 2   !< in lengths of the wing
  !> [Pa] range of Young's modulus that a force and a deformation may mean. For veins with E of 0.1 to 100 GPa, the estimate is E/25
  !> to E, so that an error of a factor of 1000 is noticed for usual E.
  real(rp), parameter :: SOFTEST = 2.0e6_rp, STIFFEST = 3.0e11_rp

contains

  !> Reports what is wrong with the parts of `m` that were read; `wing` is valid.
  subroutine check_measurement(m, wing, report)
    type(measurement_t), intent(in) :: m
    type(wing_t), intent(in) :: wing
    type(wing_report_t), intent(inout) :: report
    real(rp) :: root(3), length
    logical :: is_comparable
    integer :: i, l
    root = sum(wing%points(:, wing%root), 2)/size(wing%root)
    length = sqrt(maxval(sum((wing%points - spread(root, 2, size(wing%points, 2)))**2, 1)))
    call check_orders(m, report)
    if (m%count_modes() > 0) call check_modes(m%modes, wing, length, report)
    if (m%count_series() > 0) call check_series(m%series, wing, length, report)
    do l = 1, size(m%loads)
      if (.not. is_on_wing(m%loads(l)%point)) &
        call report%add('/loads/'//m%loads(l)%name, 'attribute point: '//off_wing(m%loads(l)%point))
      if (.not. m%loads(l)%has_surface .and. .not. any(m%observations%load == l)) &
        call report%add('/loads/'//m%loads(l)%name, 'has no observation: add heights z, or an object in /points')
    end do
    do i = 1, size(m%observations)
      if (.not. is_on_wing(m%observations(i)%point)) &
        call report%add('/points/'//m%observations(i)%name, 'attribute point: '//off_wing(m%observations(i)%point))
    end do
    if (m%accuracy%height > length) call report%add('/accuracy', 'attribute height, the sd of a height, is '// &
      number_text(m%accuracy%height)//' m, and the wing is '//number_text(rounded(length, 3))//' m long; is it in metres?')
    if (size(m%x) < 2 .or. size(m%y) < 2) return
    if (size(wing%triangles) == 0) then
      call report%add('/reference', 'heights can only be compared with a wing that has triangles; use /points')
      return
    end if
    is_comparable = all(m%x(2:) > m%x(:size(m%x) - 1)) .and. all(m%y(2:) > m%y(:size(m%y) - 1))
    if (is_comparable) call check_scale(m, length, is_comparable, report)
    if (is_comparable) call check_surfaces(m, wing, root, length, report)

  contains

    logical function is_on_wing(point)
      real(rp), intent(in) :: point(2)
      type(material_point_t) :: place
      place = find_material_point(wing%points, wing%triangles, length, point)
      is_on_wing = place%is_found
    end function is_on_wing

    !> Returns a message about a point that is not on the wing.
    function off_wing(point) result(text)
      real(rp), intent(in) :: point(2)
      character(:), allocatable :: text
      real(rp) :: distance
      integer :: k
      distance = huge(distance)
      do k = 1, size(wing%points, 2)
        distance = min(distance, norm2(wing%points(:2, k) - point))
      end do
      text = '('//number_text(point(1))//', '//number_text(point(2))//') m is not on the wing; '// &
             'its nearest point is '//number_text(real(real(distance), rp))//' m away'
      if (size(wing%triangles) == 0) text = text//', more than '//number_text(NEAR)//' of the length'
    end function off_wing

  end subroutine check_measurement

  !> Reports loads that have the same order.
  subroutine check_orders(m, report)
    type(measurement_t), intent(in) :: m
    type(wing_report_t), intent(inout) :: report
    integer :: l, k
    do l = 2, size(m%loads)
      if (m%loads(l)%order == 0) cycle
      do k = 1, l - 1
        if (m%loads(k)%order == m%loads(l)%order) &
          call report%add('/loads/'//m%loads(l)%name, 'attribute order is '//number_text(m%loads(l)%order)// &
                          ', as in '//m%loads(k)%name//'; every load needs its own order')
      end do
    end do
  end subroutine check_orders

  !> Checks that the extent of the grid is comparable with the wing's length.
  subroutine check_scale(m, length, ok, report)
    type(measurement_t), intent(in) :: m
    real(rp), intent(in) :: length
    logical, intent(out) :: ok
    type(wing_report_t), intent(inout) :: report
    real(rp) :: extent
    extent = max(m%x(size(m%x)) - m%x(1), m%y(size(m%y)) - m%y(1))
    ok = extent <= MOST_SCALE*length .and. MOST_SCALE*extent >= length
    if (.not. ok) call report%add('/reference/x, /reference/y', 'the grid extends over '//number_text(rounded(extent, 3))// &
                                  ' m and the wing over '//number_text(rounded(length, 3))//' m; are the grid lines in metres?')
  end subroutine check_scale

  !> Checks that there are known heights on the wing, of a size that the wing and the force permit.
  subroutine check_surfaces(m, wing, root, length, report)
    type(measurement_t), intent(in) :: m
    type(wing_t), intent(in) :: wing
    real(rp), intent(in) :: root(3), length
    type(wing_report_t), intent(inout) :: report
    type(surface_sample_t) :: sample
    integer, allocatable :: number(:, :), edges(:, :)
    character(:), allocatable :: object
    real(rp) :: largest, inertia, modulus
    integer :: l, k
    edges = outline_edges(size(wing%points, 2), wing%triangles)
    inertia = 0
    do k = 1, size(wing%veins)
      inertia = inertia + PI/64*maxval(wing%veins(k)%diameters)**4
    end do
    allocate (number(size(m%x), size(m%y)))
    do l = 1, size(m%loads)
      associate (load => m%loads(l))
        if (load%count() == 0) cycle
        object = '/loads/'//load%name
        number = 0
        do k = 1, load%count()
          number(load%node(1, k), load%node(2, k)) = k
        end do
        call sample%init(load%count())
        call sample_surface(wing%points, wing%triangles, edges, m%x, m%y, number, load%node, sample)
        largest = 0
        do k = 1, load%count()
          if (.not. sample%is_beside(k)) largest = max(largest, abs(m%deformation(l, k)))
        end do
        if (all(sample%is_beside)) then
          call report%add(object//'/z', 'none of the '//number_text(load%count())//' known heights is on the wing')
        else if (largest > MOST_DEFORMATION*length) then
          call report%add(object//'/z', 'the largest deformation is '//number_text(rounded(largest, 3))//' m and the wing is '// &
                          number_text(rounded(length, 3))//' m long; are the heights in metres?')
        else if (largest > 0 .and. inertia > 0 .and. load%force > 0) then
          modulus = load%force*norm2(load%point - root(:2))**3/(3*inertia*largest)
          if (modulus < SOFTEST .or. modulus > STIFFEST) &
            call report%add(object, 'the force of '//number_text(load%force)//' N and the deformation of '// &
                            number_text(rounded(largest, 3))//' m would mean veins of about '// &
                            number_text(rounded(modulus, 2))// &
                            ' Pa; are the force in newtons and the heights in metres?')
        end if
      end associate
    end do
  end subroutine check_surfaces
end module measurement_check
