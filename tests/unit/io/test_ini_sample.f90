! SPDX-License-Identifier: GPL-3.0-or-later
!> A small register with keys of every kind, and a file that uses them all, for the tests of the reader.
module test_ini_sample
  use base_kinds, only: rp
  use io_registry, only: registry_t
  implicit none
  private
  public :: register_sample, sample_text

  character(*), parameter :: NL = achar(10)

contains

  subroutine register_sample(r)
    type(registry_t), intent(inout) :: r
    call r%add_section('Resolution', 'Points of the grid.')
    call r%add_integer('Resolution', 'nx', 8, 'points in x', unit='points', min=1, max=4096)
    call r%add_integer('Resolution', 'ny', 4, 'points in y', unit='points', min=1, required=.true.)
    call r%add_section('Geometry', 'The box.')
    call r%add_real('Geometry', 'yl', 6.283185307179586_rp, 'length of the box', unit='L', above=0.0_rp)
    call r%add_length('Geometry', 'y0', 'yl/2', 'centre', unit='L')
    call r%add_length('Geometry', 'thickness', '4*dx', 'thickness of walls', unit='L', min=0.0_rp)
    call r%set_lattice('Resolution', 'ny', 'Geometry', 'yl')
    call r%add_section('Time', 'Time stepping.')
    call r%add_real('Time', 'Tmax', 1.0_rp, 'end of the run', unit='T', min=0.0_rp, required=.true.)
    call r%add_real('Time', 'CFL', 0.1_rp, 'CFL number', above=0.0_rp, max=1.0_rp)
    call r%add_word('Time', 'iTimeMethodFluid', 'AB2', 'AB2|RK4', 'time stepper', unbuilt='RK2|FSI_*')
    call r%add_switch('Time', 'intelligent_dt', .false., 'meet output times')
    call r%add_section('InitialCondition', '')
    call r%add_word('InitialCondition', 'inicond', 'quiescent', 'quiescent|backup::*', 'initial flow')
    call r%add_text('InitialCondition', 'file_ux', 'none', 'file | with u_x')
    call r%add_switch('Penalization', 'iMoving', .false., 'moving body', unbuilt='moving bodies')
    call r%add_reals('Penalization', 'us_fixed', [0.0_rp, 0.5_rp, 0.0_rp], 'velocity', unit='L/T', length=3)
    call r%add_reals('Penalization', 'weights', [1.0_rp], 'weights', min=0.0_rp)
    call r%add_switch('SaveSlices', 'use_slicing', .false., 'save slices')
    call r%add_alias('SaveSlices', 'use_slicing', 'save_slices')
    call r%add_matrix('Wing', 'profile', 3, 'rows of x y z')
    call r%add_matrix('Wing', 'table', 0, 'any table')
    call r%add_inert('Saving', 'iSaveXMF', 'dead')
    call r%add_inert('Saving', 'pseud*', 'dead')
    call r%add_inert_section('Insects', 'Not built.')
    call r%add_inert_section('Scalar*', 'Not built.')
    call r%add_switch('Insects', 'use_insects', .false., 'insects', unbuilt='insects')
  end subroutine register_sample

  !> A file without mistakes, in the style of FLUSI's users.
  function sample_text() result(text)
    character(:), allocatable :: text
    text = '; ------- a run ---------'//NL// &
           '[Resolution]'//NL//'nx=32;'//NL//'ny = 64 ; points'//NL//NL// &
           '[Geometry]'//NL//'; size of the box'//NL//'yl=2.0; new: default value is 2*pi'//NL//'y0=16*dx;'//NL// &
           'thickness=; default thickness is 4*dx'//NL//NL// &
           '[Time]'//NL//'# final time'//NL//'Tmax=20.0d0;'//NL//'; nt=;'//NL//'CFL=0.5 % number'//NL// &
           'iTimeMethodFluid=RK4; AB2, RK4'//NL//'intelligent_dt=yes;'//NL//NL// &
           '[InitialCondition]'//NL//'inicond=backup::file.h5'//NL//'file_ux=my file.h5;'//NL//NL// &
           '[Penalization]'//NL//'iMoving=0;'//NL//'us_fixed=0 -1.5e0 +3;'//NL//'weights=1,2,3,4'//NL//NL// &
           '[SaveSlices]'//NL//'save_slices=.true.;'//NL//NL// &
           '[Wing]'//NL//'profile=(/ 0 1 2'//NL//'3  4 5 ; second'//NL//'6 7 8 /);'//NL//'table=(/ 1 2 /)'//NL// &
           NL// &
           '[Saving]'//NL//'iSaveXMF=0;'//NL//'pseudoeps=1;'//NL//NL// &
           '[Insects]'//NL//'BodyType=drosophila'//NL//'HasDetails=all; legs; no;'//NL//NL// &
           '[Scalar1]'//NL//'kappa=0.01;'//NL
  end function sample_text
end module test_ini_sample
