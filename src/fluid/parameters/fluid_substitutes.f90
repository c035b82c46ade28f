! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists substitutes for the words of FLUSI that this program lacks, in the form that the registry of keys takes: 'word:
!> sentence|word*: sentence'. A word that ends in * stands for all words that begin with the part before it.
module fluid_substitutes
  implicit none
  private

  character(*), parameter :: FIELDS = 'fields that you make, inicond = infile with file_ux, file_uy, file_uz'
  character(*), parameter :: RANDOM = 'turbulence_rogallo or random-given-spectrum'
  character(*), parameter :: MHD = 'nothing, this belongs to magnetohydrodynamics'
  character(*), parameter :: DRAWN = 'a mask that you draw, iMask = from_file::mask.h5'
  character(*), parameter :: BODY = 'iMask = Insect with [Insects] BodyType = revolution, BodyMotion = '// &
    'from_file:: a table of its way, LeftWing = no, RightWing = no'

  character(*), parameter, public :: NO_STEPPERS = 'krylov|FSI_RK*'
  character(*), parameter, public :: FOR_STEPPERS = &
    'krylov: AB2 or RK4, in which viscosity is exact|'// &
    'FSI_RK*: AB2 with [Flexible_wing] coupling, for wings = flexible'

  character(*), parameter, public :: NO_FLOWS = &
    'turbulence|turbulence-meanflow|half_HIT|2VortexRings|vortex|three-vortices|couette|blob|pressure-blob|'// &
    'infile_inlet|infile_perturbed|orszag|orszagtang|constant|smc*|tc*|TaylorCouette'
  character(*), parameter, public :: FOR_FLOWS = &
    'turbulence: '//RANDOM//'|turbulence-meanflow: '//RANDOM//', and [MeanFlow] ux, uy, uz|'// &
    'half_HIT: '//FIELDS//'|2VortexRings: '//FIELDS//'|vortex: '//FIELDS//'|three-vortices: '//FIELDS//'|'// &
    'blob: '//FIELDS//'|orszag: '//FIELDS//'|couette: quiescent with iMask = couette, which starts the flow|'// &
    'pressure-blob: nothing, this belongs to artificial compressibility|'// &
    'infile_inlet: infile, with a field that fills the box|'// &
    'infile_perturbed: infile, with a field that you have perturbed (tools/postprocess simple-field-operation)|'// &
    'orszagtang: '//MHD//'|constant: '//MHD//'|smc*: '//MHD//'|tc*: '//MHD//'|TaylorCouette: '//MHD

  character(*), parameter, public :: NO_MASKS = &
    'Flexibility|Flapper|moving_cylinder*|cylinder_asym_z|rotating_cylinder|oscillating_cylinder_2D|turek_wan|'// &
    'noncircular_cylinder|romain_open_cavity|floor*|active_grid|fractal_tree|smc*|TaylorCouette'
  character(*), parameter, public :: FOR_MASKS = &
    'Flexibility: the elastic beam is here a filament or plate of masses and springs, iMask = Insect with '// &
    '[Insects] wings = flexible as in ini/flag.ini|'// &
    'Flapper: iMask = Insect with [Insects] WingShape = rectangular|'// &
    'moving_cylinder*: '//BODY//'|oscillating_cylinder_2D: '//BODY//'|'// &
    'rotating_cylinder: iMask = couette, whose inner cylinder turns; or '//BODY//'|'// &
    'cylinder_asym_z: '//DRAWN//'|noncircular_cylinder: '//DRAWN//'|romain_open_cavity: '//DRAWN//'|'// &
    'fractal_tree: '//DRAWN//'|floor*: iChannel = xy or xz, a wall; or '//DRAWN//'|'// &
    'active_grid: '//DRAWN//', for a grid that stands still|'// &
    'turek_wan: iChannel = turek with a flexible plate, as in ini/turek-hron.ini|'// &
    'smc*: '//MHD//'|TaylorCouette: '//MHD

  character(*), parameter, public :: FOR_CAVITIES = &
    'freestream*: [Sponge] iSpongeType = cavity and a mean flow that is fixed'
  character(*), parameter, public :: FOR_CHANNELS = &
    'inlet_x: a mean flow that is fixed and [Sponge] iSpongeType = outlet_x|cylinder: '//DRAWN
  character(*), parameter, public :: FOR_SPONGES = &
    'moving_insect*: cavity, a sponge at the faces of a box that is large enough'
  character(*), parameter, public :: FOR_MEAN_FLOWS = &
    'accelerate_to_unity: fixed, or dynamic with iMeanFlowStartupConditioner'
end module fluid_substitutes
