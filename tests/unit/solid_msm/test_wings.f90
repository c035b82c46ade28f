! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the wing files named on the command line and prints their mass; exit code 1 if one is refused. A file
!> called calliphora*.h5 must have the mass that Truong et al. give for the wing of a blowfly.
program test_wings
  use base_errors, only: message_list_t
  use base_files, only: name_of
  use base_kinds, only: rp
  use solid_mass, only: mass_params_t, mass_t, lump_mass
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  character(1000) :: path
  integer :: i

  call t%start(parallel=.false.)
  do i = 1, command_argument_count()
    call get_command_argument(i, path)
    call read_one(trim(path))
  end do
  call t%check('there was a file', command_argument_count() > 0)
  call t%finish()

contains

  subroutine read_one(path)
    character(*), intent(in) :: path
    type(wing_t) :: wing
    type(mass_params_t) :: params
    type(mass_t) :: mass
    type(message_list_t) :: messages
    integer :: k
    call read_wing(path, wing, messages)
    call t%check(name_of(path)//' is accepted', messages%count() == 0)
    if (messages%count() == 0) call lump_mass(wing, params, mass, messages)
    do k = 1, messages%count()
      write (*, '(a)') '      '//messages%text(k)
    end do
    if (messages%count() > 0) return
    write (*, '(6x,i0,a,i0,a)') size(wing%points, 2), ' points, ', size(wing%triangles, 2), ' triangles'
    write (*, '(6x,3(a,f9.3),a)') 'mass [ug]: veins', 1e9_rp*mass%veins, ', membrane', 1e9_rp*mass%membrane, &
      ', total', 1e9_rp*mass%total
    write (*, '(6x,a,3f9.4,a,f8.4)') 'centre [mm]', 1e3_rp*mass%centre, ', thickness of the membrane [um]', &
      1e6_rp*mass%thickness
    write (*, '(6x,a,4es12.4)') 'inertia about the centre [kg m^2]: Ixx, Iyy, Izz, Ixy', mass%inertia(1, 1), &
      mass%inertia(2, 2), mass%inertia(3, 3), mass%inertia(1, 2)
    write (*, '(6x,a,2es10.2)') 'lightest and heaviest point [kg]', minval(mass%nodal), maxval(mass%nodal)
    if (index(name_of(path), 'calliphora') /= 1) return
    call t%check_close('total mass as published', mass%total, 250.0e-9_rp, rtol=1.0e-3_rp)
    call t%check_close('of which veins', mass%veins/mass%total, 0.6741_rp, atol=5.0e-4_rp)
    call t%check_close('length', maxval(wing%points(1, :)) - minval(wing%points(1, :)), 9.01e-3_rp, &
                       rtol=1.0e-3_rp)
    call t%check_close('mean chord', mass%area/9.01e-3_rp, 3.0e-3_rp, rtol=5.0e-3_rp)
    call t%check('ten joints', size(wing%joints) == 10)
  end subroutine read_one
end program test_wings
