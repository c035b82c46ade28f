! SPDX-License-Identifier: GPL-3.0-or-later
!> Gives the motions of a wing that FLUSI knows by name: published kinematics, as series over the cycle number, and motions of
!> model wings. The coefficients are in degrees; angles as in `fsi_wing_motion`.
module fsi_named_motions
  use base_constants, only: PI, TWO_PI
  use base_kinds, only: rp
  use fsi_wing_motion, only: wing_motion_t
  use fsi_wing_motion_series, only: angle_series_t
  implicit none
  private
  public :: set_named_motion

  real(rp), parameter :: DEGREE = PI/180

  !> The names, as the choices of a key: wings at rest, wings that flap, wings that revolve.
  character(*), parameter, public :: NAMED_MOTIONS = &
    'none|debug|debug2|Drosophila_hovering_fry|Drosophila_hovering_sun|Drosophila_hovering_maeda|flapper_sane|'// &
    'flapper_dickinson|flapper_ramamurti|suzuki|simplified|simplified2|revolving-set1|revolving-set2|revolving-set3|'// &
    'revolving-clock|revolving-anticlock'

  ! Odd harmonics of a mechanical flapper whose half-strokes have a constant speed, smoothed at the reversals.
  real(rp), parameter :: SANE_ALPHA(15) = [48.807554373967804_rp, 11.14661083909663_rp, 2.242734216805251_rp, &
         -0.6141899985692184_rp, -0.7426551158681146_rp, -0.2329560587573768_rp, 0.038749678276091284_rp, &
       0.07083462320831221_rp, 0.028982501947490313_rp, -0.0025202918494477244_rp, -0.010221019942802941_rp, &
         -0.005614021318470698_rp, 1.1958884364596903e-6_rp, 0.002186832241254999_rp, 0.0015347995090793172_rp]
  real(rp), parameter :: SANE_PHI(16) = [72.96795908179631_rp, 8.064401876272864_rp, 2.769062401215844_rp, &
               1.2200252377066352_rp, 0.5584689705779989_rp, 0.2545617536476344_rp, 0.11829515180579572_rp, &
           0.05754453975774996_rp, 0.02964141751269772_rp, 0.016177705089515895_rp, 0.009315101869467001_rp, &
        0.005625663922446026_rp, 0.0035424425357352385_rp, 0.0023130422432356247_rp, 0.001558278163264511_rp, &
         0.001078213692334021_rp]
  real(rp), parameter :: DICKINSON_ALPHA(15) = [48.23094285611071_rp, 10.224154661301371_rp, 2.1623763046726396_rp, &
        0.05049394424178093_rp, -0.17550942623071494_rp, -0.06634193748204852_rp, -0.008925020495896451_rp, &
         0.0011292567942149407_rp, 6.471071566666472e-4_rp, 1.0018757795834964e-4_rp, 3.0105550216312524e-6_rp, &
         -1.237567150768195e-6_rp, -1.988004402010933e-7_rp, -1.10165545174181e-8_rp, 2.4135650975460306e-10_rp]
  real(rp), parameter :: DICKINSON_PHI(16) = [63.24528806534019_rp, 5.753991800610726_rp, 1.3887974015525626_rp, &
         0.3889856512386744_rp, 0.10577402496901325_rp, 0.026061339604144987_rp, 0.005623376646981709_rp, &
         0.001042285996467963_rp, 1.639611509380189e-4_rp, 2.1716252827442023e-5_rp, 2.408190194815521e-6_rp, &
         2.2268710288534648e-7_rp, 1.7118916093759426e-8_rp, 1.0914870312823793e-9_rp, 5.76135101855556e-11_rp, &
         2.513944479978149e-12_rp]
  real(rp), parameter :: RAMAMURTI_ALPHA(15) = [58.5622945117485_rp, 9.70856389020196_rp, 1.06772463979698_rp, &
         -0.127455709998572_rp, -0.0553559839123380_rp, -0.00500430568361157_rp, 0.000181637429802491_rp, &
         5.24470001944736e-5_rp, 2.39488192125763e-6_rp, -1.62462115890220e-8_rp, -3.60732923972996e-9_rp, &
         -7.58943924434529e-11_rp, -3.17275659750908e-16_rp, 1.50381167957580e-14_rp, 1.41146073296091e-16_rp]
  real(rp), parameter :: RAMAMURTI_PHI(16) = [71.1023524748246_rp, 6.43355277659369_rp, 1.53592591540135_rp, &
         0.423188982190934_rp, 0.112580047175950_rp, 0.0269873997935609_rp, 0.00563410946130459_rp, &
         0.00100469248408058_rp, 0.000151188714225520_rp, 1.90437108218227e-5_rp, 1.99627349027768e-6_rp, &
         1.73399283714958e-7_rp, 1.24381425530736e-8_rp, 7.34711932879597e-10_rp, 3.56493134534579e-11_rp, &
         1.41757814786810e-12_rp]

contains

  !> Sets the angles of `motion` to those of the motion called `name`; `known` tells whether this name exists. `resting` is the
  !> feathering angle (rad) of revolving-set2 and -set3, with the sign of init_alpha_phi_theta.
  subroutine set_named_motion(name, resting, motion, known)
    character(*), intent(in) :: name
    real(rp), intent(in) :: resting
    type(wing_motion_t), intent(inout) :: motion
    logical, intent(out) :: known
    real(rp), parameter :: LEAD = 0.08_rp, SHIFT = 0.28175_rp !< of rotation before reversal, of the origin; cycles
    known = .true.
    call motion%set_constant(phi=0.0_rp, alpha=0.0_rp, theta=0.0_rp)
    select case (name)
    case ('none', 'debug2')
      call motion%set_constant(phi=0.0_rp, alpha=45*DEGREE, theta=0.0_rp)
    case ('debug')
      call motion%set_constant(phi=0.0_rp, alpha=-45*DEGREE, theta=0.0_rp)
    case ('Drosophila_hovering_fry')
      call set_fry(motion)
    case ('Drosophila_hovering_sun')
      call set_sun(motion)
    case ('Drosophila_hovering_maeda')
      call set_maeda(motion)
    case ('flapper_sane')
      ! S. P. Sane and M. H. Dickinson, J. Exp. Biol. 204, 2607 (2001), doi:10.1242/jeb.204.15.2607: the largest
      ! feathering that the protocol allows, 90 degrees.
      call set_odd_cosines(motion%phi, 0.0_rp, SANE_PHI, 0.0_rp)
      call set_odd_sines(motion%alpha, SANE_ALPHA*(90.0_rp/40), 0.0_rp)
    case ('flapper_dickinson')
      ! M. H. Dickinson, F.-O. Lehmann and S. P. Sane, Science 284, 1954 (1999), doi:10.1126/science.284.5422.1954:
      ! advanced rotation, angle of attack 40 degrees.
      call set_odd_cosines(motion%phi, 0.0_rp, DICKINSON_PHI, 0.0_rp)
      call set_odd_sines(motion%alpha, DICKINSON_ALPHA*(50.0_rp/40), LEAD)
    case ('flapper_ramamurti')
      ! R. Ramamurti and W. C. Sandberg, J. Exp. Biol. 205, 1507 (2002), doi:10.1242/jeb.205.10.1507.
      call set_odd_cosines(motion%phi, 20.0_rp, RAMAMURTI_PHI, SHIFT)
      call set_odd_sines(motion%alpha, RAMAMURTI_ALPHA, LEAD + SHIFT)
    case ('suzuki')
      ! K. Suzuki, K. Minami and T. Inamuro, J. Fluid Mech. 767, 659 (2015), doi:10.1017/jfm.2015.57.
      call motion%phi%set_fourier(0.0_rp, [80*DEGREE], [0.0_rp])
      call motion%alpha%set_flip(45*DEGREE, 3.3_rp)
    case ('simplified')
      ! T. Nakata and H. Liu, J. Comput. Phys. 231, 1822 (2012), doi:10.1016/j.jcp.2011.11.005.
      call motion%phi%set_fourier(0.0_rp, [80*DEGREE], [0.0_rp])
      call motion%alpha%set_fourier(0.0_rp, [0.0_rp], [45*DEGREE])
    case ('simplified2')
      call motion%phi%set_fourier(0.0_rp, [60*DEGREE], [0.0_rp])
    case default
      call set_revolving(name, resting, motion, known)
    end select
  end subroutine set_named_motion

  !> Gives the motions of revolving wings, with a rate of one radian or of one turn per cycle. D. Kolomenskiy, Y. Elimelech and K.
  !> Schneider, Fluid Dyn. Res. 46, 031421 (2014), doi:10.1088/0169-5983/46/3/031421.
  subroutine set_revolving(name, resting, motion, known)
    character(*), intent(in) :: name
    real(rp), intent(in) :: resting
    type(wing_motion_t), intent(inout) :: motion
    logical, intent(out) :: known
    real(rp), parameter :: TAU = 0.4_rp !< start-up time, cycles
    known = .true.
    select case (name)
    case ('revolving-set1')
      call motion%phi%set_start(TAU, 1.0_rp, TAU)
      call motion%alpha%set_constant(-45*DEGREE)
    case ('revolving-anticlock')
      call motion%phi%set_start(0.0_rp, TWO_PI, TAU)
      call motion%alpha%set_constant(-45*DEGREE)
    case ('revolving-clock')
      call motion%phi%set_start(0.0_rp, -TWO_PI, TAU)
      call motion%alpha%set_constant(45*DEGREE)
    case ('revolving-set2')
      call motion%phi%set_spin_up(1.0_rp, PI/4)
      call motion%alpha%set_constant(-resting)
    case ('revolving-set3')
      call motion%phi%set_spin_up(1.0_rp, PI/8)
      call motion%alpha%set_constant(-resting)
    case default
      known = .false.
    end select
  end subroutine set_revolving

  !> Gives a hovering fruit fly: S. N. Fry, R. Sayaman and M. H. Dickinson, J. Exp. Biol. 208, 2303 (2005), doi:10.1242/jeb.01612.
  subroutine set_fry(motion)
    type(wing_motion_t), intent(inout) :: motion
    call set_degrees(motion%phi, 25.4649398_rp, &
      [71.1061858_rp, 2.1685448_rp, -0.1986978_rp, 0.6095268_rp, -0.0311298_rp, -0.1255648_rp, -0.0867778_rp, &
       0.0543518_rp], &
      [5.4547058_rp, -3.5461688_rp, 0.6260698_rp, 0.1573728_rp, -0.0360498_rp, -0.0205348_rp, -0.0083818_rp, &
       -0.0076848_rp])
    call set_degrees(motion%alpha, -0.3056968_rp, &
      [3.3288788_rp, 0.6303878_rp, -10.9780518_rp, 2.1123398_rp, -3.2301198_rp, -1.4473158_rp, 0.6141758_rp, &
       -0.3071608_rp, 0.1458498_rp, 0.0848308_rp], &
      [67.5430838_rp, 0.6566888_rp, 9.9226018_rp, 3.9183988_rp, -2.6882828_rp, 0.6433518_rp, -0.8792398_rp, &
       -0.4817838_rp, 0.0300078_rp, -0.1015118_rp])
    call set_degrees(motion%theta, -17.8244658_rp, &
      [-3.9750378_rp, -8.2808998_rp, 0.0611208_rp, 0.3906598_rp, -0.4488778_rp, 0.120087_rp, 0.0717048_rp, &
       -0.0699578_rp], &
      [-2.2839398_rp, -3.5213068_rp, 1.9296668_rp, -1.0832488_rp, -0.3011748_rp, 0.1786648_rp, -0.1228608_rp, &
       0.0004808_rp])
  end subroutine set_fry

  !> Gives a fruit fly after take-off, sixth beat of M. W. Chen and M. Sun, Acta Mech. Sin. 30 (2014); it begins with an upstroke.
  subroutine set_sun(motion)
    type(wing_motion_t), intent(inout) :: motion
    call set_degrees(motion%phi, 38.2280144124915_rp, &
      [-60.4766838884452_rp, -5.34194400577534_rp, -2.79100982711466_rp, 0.334561891664093_rp, -0.0202655263017256_rp, &
       -0.323801616724358_rp, -0.474435962657283_rp, -0.111655938200879_rp, 0.00958151551130752_rp, &
       0.119666224142596_rp], &
      [3.00359559936894_rp, -7.55184535084148_rp, -1.32520563461209_rp, -0.297351445375239_rp, -0.213108013812305_rp, &
       -0.0328282543472566_rp, 0.0146299151981855_rp, -0.0385423658663155_rp, -0.512411386850196_rp, &
       0.0785978606299901_rp])
    call set_degrees(motion%alpha, 1.09156750841542_rp, &
      [-7.73228268249956_rp, 8.09409174482393_rp, 3.98349294858406_rp, 6.54460609657175_rp, 4.20944598804824_rp, &
       0.138380341939039_rp, 1.38813149742271_rp, 0.625930107014395_rp, 0.607953761451392_rp, -0.688049862096416_rp], &
      [-52.2064112743351_rp, -3.83568699799253_rp, -14.8200023306913_rp, 4.57428035662431_rp, 1.01656074807431_rp, &
       -0.113387395332322_rp, 0.614350733080735_rp, 0.637197524906845_rp, 0.878128257565861_rp, 0.271333646229075_rp])
    call set_degrees(motion%theta, -17.0396438317138_rp, &
      [-0.0876540586926952_rp, -6.32825811106895_rp, 0.461710021840119_rp, -0.196290365124456_rp, 0.266829219535534_rp, &
       0.191278837298358_rp, 0.0651359677824226_rp, 0.132751714936873_rp, 0.104342707251547_rp, 0.0251049936194829_rp], &
      [5.05944308805575_rp, -0.677547202362310_rp, -1.30945644385840_rp, -0.741962147111828_rp, -0.351209215835472_rp, &
       -0.0374224119537382_rp, -0.0940160961803885_rp, -0.0563224030429001_rp, 0.0533369476976694_rp, &
       0.0507212428142968_rp])
  end subroutine set_sun

  !> Gives the hovering fruit fly of Fry et al. with three harmonics, as M. Maeda and H. Liu use it (J. Biomech. Sci. Eng. 8,
  !> 2013). Published in rad, with the opposite signs of feathering and elevation.
  subroutine set_maeda(motion)
    type(wing_motion_t), intent(inout) :: motion
    call motion%phi%set_fourier(2*0.22700_rp, [1.24020_rp, 0.03610_rp, -0.00360_rp], [0.08880_rp, -0.07000_rp, &
                                                                                      0.01250_rp])
    call motion%theta%set_fourier(-2*0.16125_rp, -[0.06750_rp, 0.14500_rp, 0.00540_rp], -[0.03670_rp, 0.06840_rp, &
                                                                                          -0.03390_rp])
    call motion%alpha%set_fourier(2*0.00864_rp, -[-0.04890_rp, -0.02056_rp, 0.19649_rp], -[-1.17586_rp, -0.01216_rp, &
                                                                                           -0.17590_rp])
  end subroutine set_maeda

  !> Returns a Fourier series with coefficients in degrees.
  subroutine set_degrees(series, a0, a, b)
    type(angle_series_t), intent(inout) :: series
    real(rp), intent(in) :: a0, a(:), b(:)
    call series%set_fourier(a0*DEGREE, a*DEGREE, b*DEGREE)
  end subroutine set_degrees

  !> Returns a0/2 + sum of a_j cos(2 pi (2 j - 1)(x + shift)), in degrees.
  subroutine set_odd_cosines(series, a0, a, shift)
    type(angle_series_t), intent(inout) :: series
    real(rp), intent(in) :: a0, a(:), shift
    real(rp) :: cosines(2*size(a) - 1), sines(2*size(a) - 1)
    integer :: j
    cosines = 0
    sines = 0
    do j = 1, size(a)
      cosines(2*j - 1) = a(j)*cos(TWO_PI*(2*j - 1)*shift)
      sines(2*j - 1) = -a(j)*sin(TWO_PI*(2*j - 1)*shift)
    end do
    call set_degrees(series, a0, cosines, sines)
  end subroutine set_odd_cosines

  !> Returns the sum of b_j sin(2 pi (2 j - 1)(x + shift)), in degrees.
  subroutine set_odd_sines(series, b, shift)
    type(angle_series_t), intent(inout) :: series
    real(rp), intent(in) :: b(:), shift
    real(rp) :: cosines(2*size(b) - 1), sines(2*size(b) - 1)
    integer :: j
    cosines = 0
    sines = 0
    do j = 1, size(b)
      cosines(2*j - 1) = b(j)*sin(TWO_PI*(2*j - 1)*shift)
      sines(2*j - 1) = b(j)*cos(TWO_PI*(2*j - 1)*shift)
    end do
    call set_degrees(series, 0.0_rp, cosines, sines)
  end subroutine set_odd_sines
end module fsi_named_motions
