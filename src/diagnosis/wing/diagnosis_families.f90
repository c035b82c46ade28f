! SPDX-License-Identifier: GPL-3.0-or-later
!> Names the families of unknown causes: stiffness and forces around sites, stiffness along the veins, errors of single scans,
!> forces on a flapping wing, and errors of the sensors of records of motion.
module diagnosis_families
  use base_named_kinds, only: named_kind_t
  implicit none
  private

  integer, parameter, public :: FAMILY_STIFFNESS = 1, FAMILY_FORCE = 2, FAMILY_VEINS = 3, FAMILY_SCANS = 4, FAMILY_FLIGHT = 5, &
                                FAMILY_SENSORS = 6
  type(named_kind_t), parameter, public :: FAMILIES(6) = [named_kind_t('stiffness', FAMILY_STIFFNESS), &
                                                          named_kind_t('force', FAMILY_FORCE), &
                                                          named_kind_t('veins', FAMILY_VEINS), &
                                                          named_kind_t('scans', FAMILY_SCANS), &
                                                          named_kind_t('flight', FAMILY_FLIGHT), &
                                                          named_kind_t('sensors', FAMILY_SENSORS)]
end module diagnosis_families
