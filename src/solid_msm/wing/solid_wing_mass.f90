! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads the mass data of a wing file: the attributes `membrane_law`, `membrane_mass`, `membrane_weights`, `vein_density` and
!> `mass_source` of the file (docs/formats/wing-format.md). They are optional.
module solid_wing_mass
  use base_errors, only: failure_t
  use base_kinds, only: rp
  use base_named_kinds, only: kind_of
  use base_text, only: number_text, quoted
  use io_arrays, only: is_finite, read_attribute_reals, read_text
  use io_attributes, only: has_attribute
  use io_hdf5, only: hdf5_file_t
  use solid_wing, only: wing_mass_t, MEMBRANE_BILINEAR, MEMBRANE_LAWS, MEMBRANE_UNSTATED
  use solid_wing_report, only: wing_report_t
  implicit none
  private
  public :: read_wing_mass

contains

  !> Reads the masses that the file states. Mistakes go to `report`, and `mass` is then undefined.
  subroutine read_wing_mass(file, mass, report)
    type(hdf5_file_t), intent(in) :: file
    type(wing_mass_t), intent(out) :: mass
    type(wing_report_t), intent(inout) :: report
    type(failure_t) :: no_source, no_law, no_weights
    character(:), allocatable :: law
    mass%source = ''
    if (has_attribute(file, '/', 'mass_source')) call read_text(file, '/', 'mass_source', mass%source, no_source)
    if (has_attribute(file, '/', 'vein_density')) call read_positive(file, 'vein_density', 'kg/m^3', mass%vein_density, report)
    if (.not. has_attribute(file, '/', 'membrane_law')) then
      if (has_attribute(file, '/', 'membrane_mass')) &
        call report%add('attribute membrane_law', 'missing, although there is membrane_mass; valid: uniform | bilinear')
      return
    end if
    call read_text(file, '/', 'membrane_law', law, no_law)
    if (.not. no_law%failed) mass%law = kind_of(MEMBRANE_LAWS, law)
    if (mass%law == MEMBRANE_UNSTATED) then
      call report%add('attribute membrane_law', 'is '//quoted(law)//'; valid: uniform | bilinear')
      return
    end if
    call read_positive(file, 'membrane_mass', 'kg', mass%membrane, report)
    if (mass%law == MEMBRANE_BILINEAR) then
      call read_attribute_reals(file, '/', 'membrane_weights', mass%weights, no_weights)
      if (no_weights%failed .or. .not. all(is_finite(mass%weights))) &
        call report%add('attribute membrane_weights', 'missing or not three reals w1, w2 [1/m], w3 [1/m]: the areal density '// &
                        'of a bilinear law is proportional to w1 + w2 x + w3 y')
    end if
    if (mass%source == '') call report%add('attribute mass_source', 'missing or not a text: it says where the mass comes from')
  end subroutine read_wing_mass

  !> Reads an attribute that must be a positive number.
  subroutine read_positive(file, name, unit, value, report)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name, unit
    real(rp), intent(out) :: value
    type(wing_report_t), intent(inout) :: report
    real(rp) :: values(1)
    type(failure_t) :: failure
    call read_attribute_reals(file, '/', name, values, failure)
    value = values(1)
    if (failure%failed) then
      call report%add('attribute '//name, 'missing or not a real ['//unit//']')
    else if (.not. (value > 0 .and. is_finite(value))) then
      call report%add('attribute '//name, 'is '//number_text(value)//' '//unit//'; it must be positive')
    end if
  end subroutine read_positive
end module solid_wing_mass
