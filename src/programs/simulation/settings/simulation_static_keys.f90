! SPDX-License-Identifier: GPL-3.0-or-later
!> Declares the ini keys of `flusi --static`. All units are SI.
module simulation_static_keys
  use base_kinds, only: rp
  use common_foreign_inputs, only: register_foreign_inputs, INPUT_OF_STATIC
  use common_instrument, only: register_idle_instrument
  use common_solver_keys, only: solver_keys
  use common_wing_keys, only: register_wing_keys, PLACE_HELP
  use io_include, only: register_include
  use io_keys, only: declaring, keys_t
  use io_registry, only: registry_t
  use solid_statics, only: static_options_t
  implicit none
  private
  public :: static_choices_t, static_keys, register_static_keys, write_static_reference

  !> Holds what a user chooses apart from the wing.
  type :: static_choices_t
    real(rp), allocatable :: forces(:, :), point_forces(:, :) !< x y force; point fx fy fz
    character(:), allocatable :: named_forces
    type(static_options_t) :: options
    character(:), allocatable :: name      !< of the files to write
    logical :: save_shapes = .true.
    integer :: n_modes = 0
    real(rp) :: gravity(3) = 0             !< [m/s^2]
  end type static_choices_t

contains

  !> Fills `registry` with every key that `flusi --static` accepts.
  subroutine register_static_keys(registry)
    type(registry_t), intent(inout), target :: registry
    type(static_choices_t) :: unused
    type(keys_t) :: keys
    call register_include(registry)
    call register_foreign_inputs(registry, INPUT_OF_STATIC)
    call register_wing_keys(registry, required=.true.)
    call register_idle_instrument(registry)
    keys = declaring(registry)
    call static_keys(keys, unused)
  end subroutine register_static_keys

  !> Writes the reference of these keys, the second part of docs/formats/parameters.md, to `unit`.
  subroutine write_static_reference(unit)
    integer, intent(in) :: unit
    type(registry_t) :: registry
    call register_static_keys(registry)
    write (unit, '(a)') '# Parameters of `flusi --static`', '', &
      'The shape of a wing under given loads. All numbers are in SI units.', ''
    call registry%write_markdown(unit)
  end subroutine write_static_reference

  !> Declares and reads all keys except those of the wing.
  subroutine static_keys(keys, c)
    type(keys_t), intent(inout) :: keys
    type(static_choices_t), intent(inout) :: c
    call keys%section('Loads', 'every row, and every entry of a list, is a separate load; the rows of forces come first, then '// &
                      'the rows of point_forces, then the lists')
    call keys%matrix('forces', c%forces, 3, 'rows of x y force: position on the unloaded membrane [m], force along z [N]')
    call keys%matrix('point_forces', c%point_forces, 4, 'rows of point fx fy fz: number of the point counted from 1, force [N]')
    call keys%text('named_forces', c%named_forces, '', 'loads PLACE fx fy fz [N], separated by commas; + joins several forces '// &
                   'to one load. '//PLACE_HELP)
    call keys%reals('gravity', c%gravity, [0.0_rp, 0.0_rp, 0.0_rp], 'acceleration of gravity in the wing frame: the weight is '// &
                    'part of every load, and is a separate load if there is no other', unit='m/s^2')
    call keys%section('Modes', 'natural frequencies and shapes of the unloaded wing')
    call keys%integer('modes', c%n_modes, 0, 'number of modes, lowest first', min=0, max=100)
    call solver_keys(keys, c%options, 900)
    call keys%section('Saving', 'what is written')
    call keys%text('name', c%name, 'static', 'first part of the names of all output files; it may contain a folder')
    call keys%switch('shapes', c%save_shapes, .true., 'one HDF5 file and one XDMF index for every load')
  end subroutine static_keys
end module simulation_static_keys
