! SPDX-License-Identifier: GPL-3.0-or-later
!> Wing planforms: outlines from files, and their triangles.
program test_planform
  use base_constants, only: PI
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use free_perimeter, only: perimeter_of
  use fsi_planform, only: planform_t
  use fsi_planform_file, only: read_planform_text
  use fsi_planform_mesh, only: triangulate_planform
  use fsi_rigid_body, only: rigid_body_t
  use fsi_solid_shape, only: shape_holder_t
  use fsi_surface, only: surface_t
  use fsi_wing_solids, only: fourier_wing_t, make_fourier_wing
  use io_broadcast_text, only: read_text_file
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = new_line('a')
  character(*), parameter :: FOURIER = '[Wing]'//NL//'type=fourier'//NL//'a0_wings=0.6;'//NL//'x0w=-0.1;'//NL// &
                             'y0w=0.5;'//NL
  type(testkit_t) :: kit
  type(planform_t) :: planform, other
  character(1024) :: folder
  real(rp) :: span(2), trailing, leading
  integer :: crossings

  call kit%start(parallel=.false.)
  call get_command_argument(1, folder)

  ! R = 0.3 + 0.05 cos(theta): theta = pi points to FLUSI's +x_w, which is the leading edge, +y here.
  planform = planform_of(FOURIER//'ai_wings=0.05 0.0;'//NL//'bi_wings=0.0 0.0;')
  call planform%chord_at(0.5_rp, trailing, leading, crossings)
  call kit%check_close('the Fourier outline has its a_1 at the leading edge', leading, -0.1_rp + 0.25_rp, atol=1e-5_rp)
  call kit%check_close('and at the trailing edge', trailing, -0.1_rp - 0.35_rp, atol=1e-5_rp)
  call kit%check_close('its area is that of the series', planform%area(), PI*(0.3_rp**2 + 0.05_rp**2/2), rtol=1e-5_rp)
  ! b_1 sin(theta): theta = pi/2 is -y_w in FLUSI, the root.
  planform = planform_of(FOURIER//'ai_wings=0.0'//NL//'bi_wings=0.02')
  span = planform%span()
  call kit%check_close('b_1 > 0 moves the outline to the root', span(1), 0.5_rp - 0.32_rp, atol=1e-5_rp)
  call kit%check_close('and away from the tip', span(2), 0.5_rp + 0.28_rp, atol=1e-5_rp)
  planform = planform_of(FOURIER//'ai_wings=0.01 0.002 0.001 0.0'//NL//'bi_wings=0.0 0.01 0.0 0.003')
 other = planform_of(FOURIER//'ai_wings=(/ 0.01 0.002'//NL//'0.001 0.0/)'//NL//'bi_wings=(/0.0 0.01'//NL//'0.0 0.003/)')
  call kit%check('coefficients may stand in a matrix, row by row', all(abs(planform%outline - other%outline) <= 0))

  planform = planform_of('[Wing]'//NL//'type=rectangular'//NL//'root=0.1'//NL//'length=1'//NL//'mean_chord=0.3'// &
                         NL//'front=0.25')
  call kit%check_close('a rectangle has its area', planform%area(), 0.27_rp, rtol=1e-14_rp)
  call test_mesh('rectangle', planform, 0.05_rp, 1.0e-13_rp, perimeter=2.4_rp)
  planform = planform_of('[Wing]'//NL//'type=ellipse'//NL//'length=1'//NL//'mean_chord=0.3')
  call kit%check_close('an ellipse has its mean chord', planform%mean_chord(), 0.3_rp, rtol=1e-5_rp)
  call test_mesh('ellipse', planform, 0.02_rp, 3.0e-3_rp)
  call test_convergence(planform)
  planform = planform_of('[Wing]'//NL//'type=polygon'//NL//'outline=(/0 0'//NL//'1 0'//NL//'0.8 -0.3'//NL//'0 -0.2/)')
  call kit%check_close('a polygon has its area', planform%area(), 0.23_rp, rtol=1e-14_rp)
  call test_mesh('polygon', planform, 0.03_rp, 1.0e-2_rp)

  call test_calliphora()
  call test_relief()
  call test_mistakes()
  call kit%finish()

contains

  !> Reads a planform that must be right.
  function planform_of(text) result(planform)
    character(*), intent(in) :: text
    type(planform_t) :: planform
    type(message_list_t) :: errors, notices
    integer :: i
    call read_planform_text(text, 'wing.ini', planform, errors, notices)
    do i = 1, errors%count()
      call kit%check('no mistake: '//errors%text(i), .false.)
    end do
    if (errors%count() > 0) call kit%finish()
  end function planform_of

  !> Orientation, edge lengths, closedness and area of the triangles.
  subroutine test_mesh(name, planform, edge, tolerance, perimeter)
    character(*), intent(in) :: name
    type(planform_t), intent(in) :: planform
    real(rp), intent(in) :: edge, tolerance
    real(rp), intent(in), optional :: perimeter
    type(surface_t) :: surface
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    real(rp) :: smallest, longest
    integer :: i, k, used
    call triangulate_planform(planform, edge, points, triangles)
    call surface%init(points, triangles, 2)
    smallest = huge(smallest)
    longest = 0
    do i = 1, size(triangles, 2)
     associate (a => points(1:2, triangles(1, i)), b => points(1:2, triangles(2, i)), c => points(1:2, triangles(3, i)))
        smallest = min(smallest, ((b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1)))/2)
      end associate
      do k = 1, 3
        longest = max(longest, norm2(points(:, triangles(k, i)) - points(:, triangles(mod(k, 3) + 1, i))))
      end do
    end do
    call kit%check(name//': all triangles are counter-clockwise seen from +z', smallest > 0)
    call kit%check_below(name//': no edge is longer than twice the wanted length', longest, 2*edge)
    call kit%check_close(name//': the triangles have the area of the outline', surface%area(), planform%area(), &
                         rtol=tolerance)
    used = count([(any(triangles == i), i=1, size(points, 2))])
    call kit%check(name//': every point belongs to a triangle', used == size(points, 2))
    if (present(perimeter)) call kit%check_close(name//': the free edges are the outline', perimeter_of(surface), &
                                                 perimeter, rtol=1.0e-13_rp)
  end subroutine test_mesh

  !> Rows follow a round tip, so that the area converges to second order there too.
  subroutine test_convergence(planform)
    type(planform_t), intent(in) :: planform
    type(surface_t) :: surface
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    real(rp), parameter :: EDGES(3) = [0.08_rp, 0.04_rp, 0.02_rp]
    real(rp) :: errors(3)
    integer :: i
    do i = 1, 3
      call triangulate_planform(planform, EDGES(i), points, triangles)
      call surface%init(points, triangles, 2)
      errors(i) = abs(surface%area() - planform%area())
    end do
    ! A tolerance of 0.35, because rows come in whole numbers.
    call kit%check_order('the area of a triangulated ellipse', EDGES, errors, 2.0_rp, 0.35_rp)
  end subroutine test_convergence

  !> The shipped blowfly wing.
  subroutine test_calliphora()
    type(planform_t) :: wing
    type(message_list_t) :: errors, notices
    real(rp), allocatable :: points(:, :)
    integer, allocatable :: triangles(:, :)
    character(:), allocatable :: text, problem
    real(rp) :: span(2)
    call read_text_file(trim(folder)//'/calliphora.ini', text, problem)
    call kit%check('ini/wings/calliphora.ini can be read', .not. allocated(problem))
    if (allocated(problem)) return
    call read_planform_text(text, 'calliphora.ini', wing, errors, notices)
    call kit%check('ini/wings/calliphora.ini is right', errors%count() == 0)
    if (errors%count() > 0) return
    span = wing%span()
    call kit%check_close('the blowfly wing begins at the hinge', span(1), 0.0_rp, atol=1.0e-18_rp)
    call kit%check_close('it is 9.0 mm long', span(2), 9.0e-3_rp, rtol=1.0e-14_rp)
    call kit%check_close('its mean chord is 3.004 mm', wing%mean_chord(), 3.004e-3_rp, rtol=1.0e-13_rp)
    call test_mesh('blowfly wing', wing, 0.184e-3_rp, 5.0e-3_rp)
    call triangulate_planform(wing, 0.193e-3_rp, points, triangles)
    call kit%check_close('an edge of 0.193 mm gives about 1600 triangles', real(size(triangles, 2), rp), 1600.0_rp, &
                         rtol=0.05_rp)
  end subroutine test_calliphora

  !> A round wing whose height and thickness are bilinear, along the chord c and the span s: z = c + 2 s + 3 c s, t = 0.1 (1 + s).
  subroutine test_relief()
    type(planform_t) :: wing
    type(fourier_wing_t) :: solid
    type(rigid_body_t) :: body
    type(shape_holder_t), allocatable :: parts(:)
    character(*), parameter :: RELIEF = 'ai_wings=0.0'//NL//'bi_wings=0.0'//NL//'corrugated=yes'//NL// &
      'wing_thickness_distribution=variable'//NL//'corrugation_array_bbox=-1 1 0 1'//NL// &
      'corrugation_profile=(/-1 -2'//NL//'0 2'//NL//'1 6/)'//NL//'wing_thickness_profile=(/0.1 0.2'//NL//'0.1 0.2/)'
    real(rp), parameter :: C = -0.13_rp, S = 0.61_rp, H = 0.02_rp, Z = C + 2*S + 3*C*S, T = 0.1_rp*(1 + S)
    wing = planform_of(FOURIER//RELIEF)
    call kit%check_close('the height is bilinear', wing%relief%height_at(C, S), Z, rtol=1.0e-14_rp)
    call kit%check_close('so is the thickness', wing%relief%thickness_at(C, S, 9.0_rp), T, rtol=1.0e-14_rp)
    call kit%check('there is nothing beyond the box', .not. any(abs([wing%relief%height_at(0.0_rp, 1.01_rp), &
                                                     wing%relief%thickness_at(1.01_rp, 0.5_rp, 9.0_rp)]) > 0))
    solid = make_fourier_wing(wing%fourier, wing%outline, 9.0_rp, wing%relief)
    call kit%check_close('half of chi is half the thickness above that height', solid%mask_at([S, C, Z + T/2], H), 0.5_rp, &
                         rtol=1.0e-12_rp)
    call kit%check_close('all of it in the middle', solid%mask_at([S, C, Z], H), 1.0_rp, rtol=1.0e-12_rp)
    solid%side = -1
    call kit%check_close('the other wing is a mirror image', solid%mask_at([S, C, -Z - T/2], H), 0.5_rp, rtol=1.0e-12_rp)
    allocate (parts(1))
    allocate (parts(1)%shape, source=solid)
    call body%init(parts, H)
    ! The outline is a circle of radius 0.3 about (-0.1, 0.5); its step adds pi h^2 (1 - 8/pi^2). Moments are sums over
    ! points h/2 apart.
    call kit%check_close('its volume is area times mean thickness', body%displaced%mass, &
                         0.15_rp*PI*(0.3_rp**2 + H**2*(1 - 8/PI**2)), rtol=2.0e-3_rp)
    wing%relief = wing%relief%scaled(2.0_rp)
    call kit%check_close('twice as large', wing%relief%height_at(2*C, 2*S), 2*Z, rtol=1.0e-14_rp)
    wing = planform_of(FOURIER//'length=0.4'//NL//RELIEF) ! half as large, as the tip was at 0.8
    call kit%check_close('as large as length says', wing%relief%height_at(C/2, S/2), Z/2, rtol=1.0e-14_rp)
  end subroutine test_relief

  subroutine test_mistakes()
    call refuse('an unknown type', 'type=delta', 'type')
    call refuse('no coefficients', 'type=fourier', 'a0_wings')
    call refuse('series of different lengths', 'type=fourier'//NL//'a0_wings=1'//NL//'ai_wings=0.1'//NL// &
                'bi_wings=0.1 0.2', 'bi_wings')
    call refuse('a rectangle without length', 'type=rectangular'//NL//'mean_chord=1', 'length')
    call refuse('an ellipse without chord', 'type=ellipse'//NL//'length=1', 'mean_chord')
    call refuse('a polygon of two points', 'type=polygon'//NL//'outline=(/0 0'//NL//'1 0/)', 'outline')
    call refuse('a repeated point', 'type=curve'//NL//'outline=(/0 0'//NL//'1 0'//NL//'1 0'//NL//'0 -1/)', 'outline')
    call refuse('two chords at one x', 'type=polygon'//NL//'outline=(/0 0'//NL//'1 0'//NL//'1 -1'//NL//'0 -1'//NL// &
                '0.9 -0.7'//NL//'0 -0.5/)', 'type')
    call refuse('a wing behind its hinge', 'type=polygon'//NL//'outline=(/-2 0'//NL//'-1 0'//NL//'-1 1/)', 'type')
    call refuse('corrugation of an ellipse', 'type=ellipse'//NL//'length=1'//NL//'mean_chord=1'//NL// &
                'corrugated=yes', 'corrugated')
    call refuse('corrugation without a profile', 'type=fourier'//NL//'a0_wings=0.6'//NL//'ai_wings=0.0'//NL//'bi_wings=0.0'// &
                NL//'corrugated=yes', 'corrugation_profile')
    call refuse('a negative thickness', 'type=fourier'//NL//'a0_wings=0.6'//NL//'ai_wings=0.0'//NL//'bi_wings=0.0'// &
                NL//'wing_thickness_distribution=variable'//NL//'wing_thickness_profile=(/0.1 0.1'//NL//'0.1 -0.1/)', &
                'wing_thickness_profile')
  end subroutine test_mistakes

  !> The text must be refused with a message that names `key`.
  subroutine refuse(what, text, key)
    character(*), intent(in) :: what, text, key
    type(planform_t) :: planform
    type(message_list_t) :: errors, notices
    integer :: i
    logical :: named
    call read_planform_text('[Wing]'//NL//text//NL, 'wing.ini', planform, errors, notices)
    named = .false.
    do i = 1, errors%count()
      named = named .or. index(errors%text(i), '[Wing] '//key//':') > 0
    end do
    call kit%check(what//' is a mistake of '//key, named)
  end subroutine refuse
end program test_planform
