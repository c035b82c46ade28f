! SPDX-License-Identifier: GPL-3.0-or-later
!> Declares the ini keys of a wing that all programs share: its file, stiffness, mass and damping. SI units.
module common_wing_keys
  use base_kinds, only: rp
  use base_named_kinds, only: named_kind_t
  use common_wing_effects, only: effect_keys, effect_sites_t
  use io_config, only: config_t
  use io_keys, only: declaring, keys_t, reading
  use io_registry, only: registry_t
  use solid_inertia, only: inertia_t
  use solid_mass, only: mass_params_t
  use solid_wing, only: MEMBRANE_BILINEAR, MEMBRANE_LAWS, SIDE_UNSTATED, Z_SIDES
  implicit none
  private
  public :: wing_choices_t, mass_choices_t, register_wing_keys, register_damping_keys, read_wing_keys, read_mass_keys, &
            read_damping_keys

  integer, parameter, public :: WING_DEFAULT = 1, WING_PAPER = 2              !< presets
  integer, parameter, public :: CROSS_PRESET = 1, CROSS_YES = 2, CROSS_NO = 3 !< cross-springs
  type(named_kind_t), parameter :: PRESETS(2) = [named_kind_t('default', WING_DEFAULT), named_kind_t('paper', WING_PAPER)]
  type(named_kind_t), parameter :: CROSS_SPRINGS(3) = [named_kind_t('preset', CROSS_PRESET), named_kind_t('yes', CROSS_YES), &
                                                       named_kind_t('no', CROSS_NO)]
  type(named_kind_t), parameter :: STATED_SIDES(5) = [named_kind_t('file', SIDE_UNSTATED), Z_SIDES]

  !> Parameters that have a key of their own in [Wing]: E, and D for the last two.
  character(9), parameter, public :: OWN_KEYS(3) = [character(9) :: 'E', 'D', 'thickness']

  !> This is the help of every key that lists forces.
  character(*), parameter, public :: PLACE_HELP = 'PLACE: tip, vein:NAME:first, vein:NAME:last, vein:NAME:K '// &
                                     '(its K-th point), joint:NAME, point:K (from 1) or at:X:Y (on the membrane, m)'

  !> Holds the values of [Wing].
  type :: wing_choices_t
    character(:), allocatable :: file, parameters, fingerprint
    integer :: z_side = SIDE_UNSTATED            !< as in the file; else another SIDE_*
    integer :: preset = WING_DEFAULT, cross_springs = CROSS_PRESET
    logical :: has_file = .false., has_fingerprint = .false., has_found_size = .false.
    real(rp) :: length = 0, mean_chord = 0       !< [m], 0: as in the file
    real(rp) :: young = 0, spring = 0, plate = 0 !< [Pa], [N/m], [N m]
    real(rp) :: slack = 1, slack_width = 0       !< [-], [m]
    real(rp) :: joint = -1                       !< [N m/rad], -1: as the vein
    real(rp) :: found_size(2) = 0                !< [m]
    logical :: allow_other_wing = .false.
    type(effect_sites_t) :: sites
  end type wing_choices_t

  !> Holds the values of [Mass].
  type :: mass_choices_t
    integer :: law = MEMBRANE_BILINEAR           !< of the membrane
    logical :: has_law = .false., has_vein_density = .false., has_membrane_mass = .false., has_areal_density = .false.
    type(mass_params_t) :: material              !< all other keys; its membrane_law follows from `law` and the wing file
  end type mass_choices_t

contains

  !> Adds [Wing] and [Mass] to `registry`. Without `required`, a run needs no wing file.
  subroutine register_wing_keys(registry, required)
    type(registry_t), intent(inout), target :: registry
    logical, intent(in) :: required
    type(wing_choices_t) :: wing
    type(mass_choices_t) :: mass
    type(keys_t) :: keys
    keys = declaring(registry)
    call wing_keys(keys, wing, required)
    call mass_keys(keys, mass)
  end subroutine register_wing_keys

  !> Returns the values of [Wing].
  subroutine read_wing_keys(config, choices)
    type(config_t), intent(in), target :: config
    type(wing_choices_t), intent(out) :: choices
    type(keys_t) :: keys
    keys = reading(config)
    call wing_keys(keys, choices, .false.)
  end subroutine read_wing_keys

  !> Returns the values of [Mass].
  subroutine read_mass_keys(config, choices)
    type(config_t), intent(in), target :: config
    type(mass_choices_t), intent(out) :: choices
    type(keys_t) :: keys
    keys = reading(config)
    call mass_keys(keys, choices)
  end subroutine read_mass_keys

  !> Adds [Damping] to `registry`.
  subroutine register_damping_keys(registry)
    type(registry_t), intent(inout), target :: registry
    type(inertia_t) :: unused
    type(keys_t) :: keys
    real(rp) :: nodal
    keys = declaring(registry)
    call damping_keys(keys, unused, nodal)
  end subroutine register_damping_keys

  !> Returns the values of [Damping]. It changes only the damping of `inertia`; `nodal` is a force per velocity at every point
  !> [kg/s].
  subroutine read_damping_keys(config, inertia, nodal)
    type(config_t), intent(in), target :: config
    type(inertia_t), intent(inout) :: inertia
    real(rp), intent(inout) :: nodal
    type(keys_t) :: keys
    keys = reading(config)
    call damping_keys(keys, inertia, nodal)
  end subroutine read_damping_keys

  !> Visits the keys of [Wing]. With `required`, the wing file must be given.
  subroutine wing_keys(keys, c, required)
    type(keys_t), intent(inout) :: keys
    type(wing_choices_t), intent(inout) :: c
    logical, intent(in) :: required
    call keys%section('Wing', 'the wing and what it is made of')
    call keys%text('file', c%file, '', 'wing file (docs/formats/wing-format.md); the program looks in the current folder, '// &
                   'then in the folder of the input file', required=required, given=c%has_file)
    call keys%real('length', c%length, 0.0_rp, 'the wing is scaled, with all its lengths and diameters, so that its largest x '// &
                   'is this; 0: the size in its file', unit='m', min=0.0_rp)
    call keys%real('mean_chord', c%mean_chord, 0.0_rp, 'after that, y is stretched so that the area divided by the extent '// &
                   'along x is this; 0: not stretched', unit='m', min=0.0_rp)
    call keys%kind('preset', c%preset, 'default', PRESETS, 'paper: with cross-springs, as in Truong et al.')
    call keys%real('E', c%young, 12.58e9_rp, 'Young''s modulus of all veins', unit='Pa', above=0.0_rp)
    call keys%real('k_e', c%spring, 1.0e5_rp, 'extension stiffness of every spring', unit='N/m', above=0.0_rp)
    call keys%kind('cross_springs', c%cross_springs, 'preset', CROSS_SPRINGS, 'springs between the apexes of neighbouring '// &
                   'triangles; their effect depends on the mesh')
    call keys%real('D', c%plate, 2.0e-7_rp, 'bending stiffness of the membrane, a regularisation that was not measured', &
                   unit='N m', &
                   above=0.0_rp)
    call keys%real('slack', c%slack, 1.0_rp, 'tension-field model of the membrane: the fraction of their stiffness that the '// &
                   'springs keep when they are shorter than at rest; 1: all of it', above=0.0_rp, max=1.0_rp)
    call keys%real('slack_width', c%slack_width, 1.0e-7_rp, 'shortening at which a spring has lost the rest of its stiffness', &
                   unit='m', &
                   above=0.0_rp)
    call keys%real('joint_stiffness', c%joint, -1.0_rp, 'stiffness of every joint; -1: the stiffness of the vein without the '// &
                   'joint', unit='N m/rad', &
                   min=-1.0_rp)
    call keys%text('parameters', c%parameters, '', 'single parameters as pairs of name and value, separated by commas: '// &
                   'joint:NAME [N m/rad], E:VEIN (factor on E), root (factor), diameter_exponent, k_vein, k_membrane, k_cross '// &
                   '[N/m], and the effects of docs/theory/effects.md')
    call keys%kind('z_side', c%z_side, 'file', STATED_SIDES, 'side of the wing to which +z points, for '// &
                   'effects that differ between up and down; file: as the wing file says (docs/formats/wing-format.md), and '// &
                   'left ventral if it says nothing')
    call keys%text('fingerprint', c%fingerprint, '', 'identifies the wing for which these values were found; msm_train and '// &
                   'msm_diagnose write it; the program refuses another wing', given=c%has_fingerprint)
    call keys%reals('found_size', c%found_size, [0.0_rp, 0.0_rp], 'length and mean chord of the wing that was trained; '// &
                    'msm_train and msm_diagnose write them; a program warns if the wing has another size', unit='m', &
                    given=c%has_found_size)
    call keys%switch('allow_other_wing', c%allow_other_wing, .false., 'accept values that were found for another wing')
    call effect_keys(keys, c%sites)
  end subroutine wing_keys

  !> Visits the keys of [Mass].
  subroutine mass_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(mass_choices_t), intent(inout) :: c
    call keys%section('Mass', 'mass of the wing')
    call keys%real('vein_density', c%material%vein_density, 1300.0_rp, 'density of the cuticle of the veins', unit='kg/m^3', &
                   above=0.0_rp, &
                   given=c%has_vein_density)
    call keys%kind('membrane_law', c%law, 'bilinear', MEMBRANE_LAWS, 'areal density of the membrane: 1.75 - 147 x + 101 '// &
                   'y scaled to membrane_mass, or areal_density; if neither this nor areal_density is given, the law of the '// &
                   'wing file is used', given=c%has_law)
    call keys%real('membrane_mass', c%material%membrane_mass, 81.475e-9_rp, 'mass of the membrane, for membrane_law = bilinear', &
                   unit='kg', above=0.0_rp, &
                   given=c%has_membrane_mass)
    call keys%real('areal_density', c%material%areal_density, 3.0e-3_rp, 'areal density of the membrane, for membrane_law = '// &
                   'uniform', unit='kg/m^2', above=0.0_rp, &
                   given=c%has_areal_density)
    call keys%real('vein_factor', c%material%vein_factor, 1.0_rp, 'factor on the mass of all veins', above=0.0_rp)
    call keys%real('membrane_factor', c%material%membrane_factor, 1.0_rp, 'factor on the mass of the membrane, whatever its law', &
                   above=0.0_rp)
    call keys%real('membrane_gradient', c%material%gradient, 0.0_rp, 'g: the areal density of the membrane is multiplied by '// &
                   'exp(g (x/R - 1/2)), x from the root, R the extent along x', min=-5.0_rp, max=5.0_rp)
    call keys%reals('point_mass', c%material%point, [0.0_rp, 0.0_rp, 0.0_rp], 'x, y and mass of an object on the wing: dust, '// &
                   'glue, a marker', unit='m, m, kg')
  end subroutine mass_keys

  !> Visits the keys of [Damping].
  subroutine damping_keys(keys, inertia, nodal)
    type(keys_t), intent(inout) :: keys
    type(inertia_t), intent(inout) :: inertia
    real(rp), intent(inout) :: nodal
    call keys%section('Damping', 'damping of the motion relative to the wing frame')
    call keys%real('rayleigh_mass', inertia%rayleigh_mass, 0.0_rp, 'damping force per mass and velocity', unit='1/s', min=0.0_rp)
    call keys%real('rayleigh_stiffness', inertia%rayleigh_stiffness, 0.0_rp, 'damping force per rate of the elastic force', &
                   unit='s', min=0.0_rp)
    call keys%real('joint_friction', inertia%joint_friction, 0.0_rp, 'moment of the joints of veins per rate of their elastic '// &
                   'moment', unit='s', min=0.0_rp)
    call keys%real('drag', inertia%drag, 0.0_rp, 'drag of the surrounding air per area of the membrane and squared '// &
                   'velocity: half its density times the drag coefficient; 0 where the flow is simulated', unit='kg/m^3', &
                   min=0.0_rp)
    call keys%real('relaxation', inertia%relaxation, 0.0_rp, 'g of a viscoelastic wing: against a sudden force its stiffness '// &
                   'is 1 + g times the static stiffness', min=0.0_rp)
    call keys%real('relaxation_time', inertia%relaxation_time, 1.0e-3_rp, 'time in which the additional stiffness g relaxes', &
                   unit='s', above=0.0_rp)
    call keys%real('nodal', nodal, 0.0_rp, 'damping force per velocity, the same at every point', unit='kg/s', min=0.0_rp)
  end subroutine damping_keys
end module common_wing_keys
