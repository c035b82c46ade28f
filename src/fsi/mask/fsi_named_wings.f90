! SPDX-License-Identifier: GPL-3.0-or-later
!> Makes the wings that FLUSI knows by name. To add a Fourier outline, add it to one of the tables (fsi_outlines_flies,
!> fsi_outlines_bees) and its name here.
module fsi_named_wings
  use base_kinds, only: rp
  use fsi_fourier_outline, only: fourier_outline_t
  use fsi_outlines_bees, only: find_bee => find_outline
  use fsi_outlines_flies, only: find_fly => find_outline
  use fsi_planform, only: fourier_planform, planform_t, polygon_planform
  use fsi_solid_shape, only: solid_shape_t
  use fsi_wing_solids, only: make_fourier_wing, make_panel_wing
  implicit none
  private
  public :: wing_numbers_t, make_named_wing, has_chord, has_span, NAMED_WINGS

  character(*), parameter :: NAMED_WINGS = 'drosophila|drosophila_mutated|drosophila_sandberg|drosophila_maeda|'// &
    'drosophila_sun|pieris-brassicae1|bumblebee|b_ignitus|paratuposa_flatwing|paratuposa_flatelytra|flapper_sane|'// &
    'flapper_dickinsonII|robofly_dickinson|hawkmoth1|hawkmoth2|rectangular|TwoEllipses|mosquito_iams|suzuki'

  !> Values of the parameter file that some wings use, L.
  type :: wing_numbers_t
    real(rp) :: span = 1, front = 0, back = 0 !< L_span, b_top, b_bot
  end type wing_numbers_t

contains

  !> Tells whether the wing called `name` takes its chord from the parameter file.
  pure logical function has_chord(name)
    character(*), intent(in) :: name
    has_chord = name == 'rectangular' .or. name == 'TwoEllipses'
  end function has_chord

  !> Tells whether the wing called `name` takes its span from the parameter file.
  pure logical function has_span(name)
    character(*), intent(in) :: name
    has_span = has_chord(name) .or. name == 'mosquito_iams'
  end function has_span

  !> Returns the outline of the wing called `name`, `factor` times as large, and the wing as a solid of `thickness` [L]; with 0
  !> there is no solid.
  subroutine make_named_wing(name, numbers, factor, thickness, planform, solid)
    character(*), intent(in) :: name
    type(wing_numbers_t), intent(in) :: numbers
    real(rp), intent(in) :: factor, thickness
    type(planform_t), intent(out) :: planform
    class(solid_shape_t), allocatable, intent(out) :: solid
    type(fourier_outline_t) :: outline
    logical :: known
    select case (name)
    case ('rectangular')
      call panel(0.0_rp, numbers%span, numbers%front, numbers%back, .false.)
    case ('TwoEllipses')
      call panel(0.0_rp, numbers%span, numbers%front, numbers%back, .true.)
    case ('mosquito_iams')
      ! Iams (2014), SIAM J. Appl. Math. 74(5), 1535-1550.
      call panel(0.0_rp, numbers%span, 0.1474_rp, 0.1474_rp, .true.)
    case ('suzuki')
      ! Suzuki, Minami & Inamuro (2015), J. Fluid Mech. 767, 659-695.
      call panel(0.1667_rp, 1.0_rp, 0.0667_rp, 0.35_rp, .false.)
    case default
      call find_fly(name, outline, known)
      if (.not. known) call find_bee(name, outline, known)
      if (.not. known) return
      outline = outline%scaled(factor)
      planform = fourier_planform(outline%a0, outline%ai, outline%bi, outline%centre(1), outline%centre(2))
      if (thickness > 0) allocate (solid, source=make_fourier_wing(outline, planform%outline, thickness))
    end select

  contains

    !> Makes a rectangular or elliptic wing and, if it has a thickness, its solid.
    subroutine panel(root, tip, front, back, is_elliptic)
      real(rp), intent(in) :: root, tip, front, back
      logical, intent(in) :: is_elliptic
      integer, parameter :: N = 180
      real(rp), parameter :: PI = acos(-1.0_rp)
      real(rp) :: points(2, 2*N), theta
      integer :: k
      if (is_elliptic) then
        do k = 1, 2*N
          theta = PI*(k - 1)/N
          points(:, k) = factor*[(root + tip)/2 + (tip - root)/2*cos(theta), &
                                 merge(front, back, theta <= PI)*sin(theta)]
        end do
        planform = polygon_planform(points)
      else
        planform = polygon_planform(factor*reshape([root, -back, tip, -back, tip, front, root, front], [2, 4]))
      end if
      if (thickness > 0) allocate (solid, source=make_panel_wing(factor*root, factor*tip, factor*front, factor*back, &
                                                                 is_elliptic, thickness))
    end subroutine panel
  end subroutine make_named_wing
end module fsi_named_wings
