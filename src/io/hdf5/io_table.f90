! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes small tables in HDF5 files, by one process.
module io_table
  use base_errors, only: failure_t
  use base_kinds, only: i8, rp
  use io_attributes, only: put_attribute
  use io_datasets, only: write_slab
  use io_hdf5, only: hdf5_file_t
  implicit none
  private
  public :: put_table

contains

  !> Writes table(columns, rows), rows being the slow dimension of the file; nothing if it is empty.
  subroutine put_table(file, name, table, columns, failure)
    type(hdf5_file_t), intent(in) :: file
    character(*), intent(in) :: name, columns
    real(rp), intent(in) :: table(:, :)
    type(failure_t), intent(inout) :: failure
    if (size(table) == 0) return
    call write_slab(file, name, int(shape(table), i8), [0_i8, 0_i8], int(shape(table), i8), [table], .false., failure)
    call put_attribute(file, name, 'columns', columns, failure)
  end subroutine put_table
end module io_table
