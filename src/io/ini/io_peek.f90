! SPDX-License-Identifier: GPL-3.0-or-later
!> Finds the properties of a document that the reader needs before it reads the keys in order: the spacing that dx stands for, and
!> the sections that have an effect. Of several equal keys the first one counts. Values with mistakes, which are reported later,
!> count as unknown.
module io_peek
  use base_kinds, only: rp
  use io_ini, only: ini_document_t
  use io_key, only: KEY_INTEGER, matches_any
  use io_key_table, only: condition_t
  use io_registry, only: registry_t
  use io_value, only: read_value, value_t
  implicit none
  private
  public :: find_spacing, section_counts, key_counts

contains

  !> Returns the length that dx stands for, 0 if it is unknown.
  real(rp) function find_spacing(registry, document) result(spacing)
    type(registry_t), intent(in) :: registry
    type(ini_document_t), intent(in) :: document
    real(rp) :: points, length
    spacing = 0
    if (registry%points_key == 0) return
    points = peek_number(registry, document, registry%points_key)
    length = peek_number(registry, document, registry%length_key)
    if (points > 0 .and. length > 0) spacing = length/points
  end function find_spacing

  !> Tells whether the conditions of section s of the registry hold.
  logical function section_counts(registry, document, s) result(counts)
    type(registry_t), intent(in) :: registry
    type(ini_document_t), intent(in) :: document
    integer, intent(in) :: s
    counts = .true.
    if (allocated(registry%sections(s)%conditions)) counts = all_hold(registry, document, registry%sections(s)%conditions)
  end function section_counts

  !> Tells whether the conditions of key k of the registry hold.
  logical function key_counts(registry, document, k) result(counts)
    type(registry_t), intent(in) :: registry
    type(ini_document_t), intent(in) :: document
    integer, intent(in) :: k
    counts = .true.
    if (allocated(registry%keys(k)%conditions)) counts = all_hold(registry, document, registry%keys(k)%conditions)
  end function key_counts

  !> Tells whether all conditions hold in a document.
  logical function all_hold(registry, document, conditions)
    type(registry_t), intent(in) :: registry
    type(ini_document_t), intent(in) :: document
    type(condition_t), intent(in) :: conditions(:)
    integer :: i
    all_hold = .true.
    do i = 1, size(conditions)
      all_hold = all_hold .and. matches_any(raw_value(registry, document, conditions(i)%key), conditions(i)%words)
    end do
  end function all_hold

  !> Returns the value that key k will have, 0 if it is wrong or missing.
  real(rp) function peek_number(registry, document, k) result(x)
    type(registry_t), intent(in) :: registry
    type(ini_document_t), intent(in) :: document
    integer, intent(in) :: k
    type(value_t) :: value
    character(:), allocatable :: problem, raw
    x = 0
    raw = raw_value(registry, document, k)
    if (len(raw) == 0) return
    call read_value(registry%keys(k)%key, raw, .false., 0, 0.0_rp, value, problem)
    if (allocated(problem)) return
    x = value%number
    if (registry%keys(k)%key%kind == KEY_INTEGER) x = real(value%whole, rp)
  end function peek_number

  !> Returns the text of key k in the document, or else its default; empty if it is required and missing.
  function raw_value(registry, document, k) result(raw)
    type(registry_t), intent(in) :: registry
    type(ini_document_t), intent(in) :: document
    integer, intent(in) :: k
    character(:), allocatable :: raw
    integer :: i
    associate (key => registry%keys(k)%key)
      raw = ''
      if (.not. key%is_required) raw = key%default_text
      do i = 1, document%n_entries
        associate (entry => document%entries(i))
          if (registry%find(document%sections(entry%section)%name, entry%key) /= k) cycle
          if (len(entry%value) > 0 .or. entry%is_matrix) raw = entry%value
          return
        end associate
      end do
    end associate
  end function raw_value
end module io_peek
