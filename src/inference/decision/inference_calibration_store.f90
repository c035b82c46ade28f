! SPDX-License-Identifier: GPL-3.0-or-later
!> Stores the draws for a design, so that they are made only once.
!>
!> The key is a checksum of all that the draws depend on: the exact bits of the bases of candidates and families, numbers of
!> degrees of freedom, draws and seed. Stored draws are checked: a few draws are repeated, and if their values are not among the
!> stored ones, to the last bit, all are drawn again. Results are therefore the same as without a store. Another layer decides
!> where the numbers are kept.
module inference_calibration_store
  use base_checksum, only: checksum_add, checksum_integers, checksum_reals
  use base_kinds, only: i8, rp
  use inference_calibration, only: calibration_t
  use inference_design, only: design_t
  implicit none
  private
  public :: calibrate, calibration_store_t

  type, abstract :: calibration_store_t
  contains
    !> Fills the numbers of `calibration` that are kept under `key`, if there are any.
    procedure(recall_store), deferred :: recall
    !> Keeps the numbers of `calibration` under `key`. A failure is ignored: they will be drawn again.
    procedure(keep_in_store), deferred :: keep
  end type calibration_store_t

  abstract interface
    subroutine recall_store(self, key, calibration, is_found)
      import :: calibration_store_t, calibration_t, i8
      class(calibration_store_t), intent(inout) :: self
      integer(i8), intent(in) :: key
      type(calibration_t), intent(out) :: calibration
      logical, intent(out) :: is_found
    end subroutine recall_store
    subroutine keep_in_store(self, key, calibration)
      import :: calibration_store_t, calibration_t, i8
      class(calibration_store_t), intent(inout) :: self
      integer(i8), intent(in) :: key
      type(calibration_t), intent(in) :: calibration
    end subroutine keep_in_store
  end interface

contains

  !> Returns the calibration of a design: from the store, if there is one that has it, or drawn and then kept. The arguments are
  !> those of calibration_init.
  subroutine calibrate(design, n_effects, is_scale_known, n_draws, seed, calibration, store)
    type(design_t), intent(in) :: design
    integer, intent(in) :: n_effects, n_draws
    logical, intent(in) :: is_scale_known
    integer(i8), intent(in) :: seed
    type(calibration_t), intent(out) :: calibration
    class(calibration_store_t), intent(inout), optional :: store
    integer(i8) :: key
    logical :: is_found
    if (.not. present(store)) then
      call calibration%init(design, n_effects, is_scale_known, n_draws, seed)
      return
    end if
    key = design_key(design, n_effects, is_scale_known, n_draws, seed)
    call store%recall(key, calibration, is_found)
    if (is_found) then
      if (calibration%is_of(design, n_effects, is_scale_known, n_draws, seed)) return
    end if
    call calibration%init(design, n_effects, is_scale_known, n_draws, seed)
    call store%keep(key, calibration)
  end subroutine calibrate

  !> Returns the checksum of all that the draws depend on.
  integer(i8) function design_key(design, n_effects, is_scale_known, n_draws, seed) result(key)
    type(design_t), intent(in) :: design
    integer, intent(in) :: n_effects, n_draws
    logical, intent(in) :: is_scale_known
    integer(i8), intent(in) :: seed
    integer(i8) :: at
    integer :: i
    at = 0
    key = 0
    call add_integers([n_effects, n_draws, merge(1, 0, is_scale_known), design%k, design%residual_dof, &
                       size(design%candidates), size(design%families)])
    key = checksum_add(key, checksum_integers([seed], at))
    at = at + 1
    do i = 1, size(design%candidates)
      associate (one => design%candidates(i))
        call add_integers([one%effect, one%df])
        call add_reals([one%basis])
      end associate
    end do
    do i = 1, size(design%families)
      associate (one => design%families(i))
        call add_integers(shape(one%basis))
        call add_reals([one%basis])
        call add_reals([one%size_prior%gain])
        call add_reals(one%size_prior%offset)
      end associate
    end do

  contains

    subroutine add_integers(values)
      integer, intent(in) :: values(:)
      key = checksum_add(key, checksum_integers(int(values, i8), at))
      at = at + size(values)
    end subroutine add_integers

    subroutine add_reals(values)
      real(rp), intent(in) :: values(:)
      key = checksum_add(key, checksum_reals(values, at))
      at = at + size(values)
    end subroutine add_reals

  end function design_key
end module inference_calibration_store
