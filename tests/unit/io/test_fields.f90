! SPDX-License-Identifier: GPL-3.0-or-later
!> Field files written on any number of ranks come back exactly, whoever reads them.
program test_fields
  use base_errors, only: failure_t
  use base_files, only: file_exists
  use base_kinds, only: rp, sp, i8
  use io_attributes, only: get_attribute, has_attribute
  use io_datasets, only: read_slab
  use io_fields, only: field_form_t, field_meta_t, write_field, read_field, write_slice, field_label, field_file, &
                       finest_naming, slice_file, strided_points, PRECISION_SINGLE
  use io_hdf5, only: hdf5_file_t
  use parallel_block, only: block_t, split_evenly
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  integer, parameter :: N(3) = [9, 7, 5]

  call t%start(parallel=.true.)
  call test_labels()
  call test_round_trip()
  call test_strides()
  call test_plane_runs()
  call test_slices()
  call test_failures()
  call t%finish()

contains

  !> The rank's part of a grid, cut along one direction; with few points some ranks own nothing.
  function cut(n, direction) result(block)
    integer, intent(in) :: n(3), direction
    type(block_t) :: block
    block%n = n
    block%count = n
    call split_evenly(n(direction), t%world%size, t%world%rank, block%start(direction), &
                      block%count(direction))
  end function cut

  !> A value that tells its global place and needs all bits of a double. The square root is correctly
  !> rounded; sines may differ in the last bit between vectorised and scalar loops.
  pure real(rp) function place_value(i, j, k)
    integer, intent(in) :: i, j, k
    place_value = sqrt(real(i + 100*j + 10000*k + 2, rp))
  end function place_value

  function filled(block) result(data)
    type(block_t), intent(in) :: block
    real(rp), allocatable :: data(:, :, :)
    integer :: i, j, k
    allocate (data(block%count(1), block%count(2), block%count(3)))
    do k = 1, block%count(3)
      do j = 1, block%count(2)
        do i = 1, block%count(1)
          data(i, j, k) = place_value(i - 1 + block%start(1), j - 1 + block%start(2), k - 1 + block%start(3))
        end do
      end do
    end do
  end function filled

  logical function same(a, b)
    real(rp), intent(in) :: a(:, :, :), b(:, :, :)
    same = all(shape(a) == shape(b))
    if (same) same = all(abs(a - b) <= 0)
  end function same

  subroutine test_labels()
    call t%check('time 0.5 is 000500', field_label(0.5_rp, 7_i8, 'time') == '000500')
    call t%check('time is rounded to the nearest label', field_label(0.0299996_rp, 7_i8, 'time') == '000030')
    call t%check('step naming counts steps', field_label(0.5_rp, 7_i8, 'step') == '000007')
    call t%check('late times widen the label', field_label(1234.5678_rp, 7_i8, 'time') == '1234568')
    call t%check('many steps widen the label', field_label(0.5_rp, 12345678901_i8, 'step') == '12345678901')
    call t%check('micro labels have nine digits', field_label(0.5_rp, 7_i8, 'microtime') == '000500000')
    call t%check('fine intervals get micro labels', finest_naming('time', 1.9e-3_rp) == 'microtime')
    call t%check('usual intervals keep labels', finest_naming('time', 2.0e-3_rp) == 'time')
    call t%check('step naming needs no finer one', finest_naming('step', 1.0e-5_rp) == 'step')
    call t%check('field file name', field_file('ux', '000500') == 'ux_000500.h5')
    call t%check('slice file name', slice_file('u1', 42, '000500') == 'sliceu1-ix0042_000500.h5')
  end subroutine test_labels

  function example_meta() result(meta)
    type(field_meta_t) :: meta
    meta%time = 1.0_rp/3
    meta%viscosity = 1.0e-2_rp
    meta%epsi = 1.0e-3_rp
    meta%domain_size = [2.5_rp, 1.5_rp, 0.5_rp]
    meta%origin = [0.0_rp, -1.0_rp, 2.0_rp]
    meta%units = 'code units'
  end function example_meta

  subroutine test_round_trip()
    type(block_t) :: block
    type(failure_t) :: failure
    type(field_meta_t) :: meta, want
    type(hdf5_file_t) :: file
    real(rp), allocatable :: data(:, :, :)
    integer :: direction
    integer :: nxyz(3)
    integer(i8), allocatable :: dims(:)
    real(rp) :: time(1)

    want = example_meta()
    block = cut(N, 3)
    call write_field(t%world, 'ux', block, filled(block), want, field_form_t('.', '000333'), failure)
    call write_field(t%world, 'p', block, filled(block), want, field_form_t('', '000333', PRECISION_SINGLE), failure)
    call t%check('fields are written',.not. failure%failed)
    call t%check('no temporary file is left',.not. file_exists('ux_000333.h5.part'))

    do direction = 1, 3
      block = cut(N, direction)
      allocate (data(block%count(1), block%count(2), block%count(3)))
      call read_field(t%world, 'ux_000333.h5', block, data, meta, failure)
      call t%check('64-bit fields come back exactly on any cut', same(data, filled(block)) &
                   .and. .not. failure%failed)
      call read_field(t%world, './p_000333.h5', block, data, meta, failure)
      call t%check('32-bit fields come back rounded', &
                   same(data, real(real(filled(block), sp), rp)) .and. .not. failure%failed)
      deallocate (data)
    end do
    call t%check_close('time is kept', meta%time, want%time, atol=0.0_rp)
    call t%check_close('viscosity is kept', meta%viscosity, want%viscosity, atol=0.0_rp)
    call t%check_close('epsi is kept', meta%epsi, want%epsi, atol=0.0_rp)
    call t%check('domain size and origin are kept', all(abs(meta%domain_size - want%domain_size) <= 0) .and. &
                 all(abs(meta%origin - want%origin) <= 0))
    call t%check('units are kept', meta%units == 'code units')
    call t%check('the shape is told', all(meta%nxyz == N))

    call file%open_serial('p_000333.h5', failure)
    call file%dataset_shape('p', dims, failure)
    call t%check('the dataset has the Fortran shape of the field', all(dims == N))
    call get_attribute(file, 'p', 'nxyz', nxyz, failure)
    call get_attribute(file, 'p', 'time', time, failure)
    call t%check('nxyz is stored x first', all(nxyz == N) .and. .not. failure%failed)
    call t%check('missing attributes are seen',.not. has_attribute(file, 'p', 'pressure'))
    call file%close(failure)
  end subroutine test_round_trip

  subroutine test_strides()
    type(block_t) :: block, coarse
    type(failure_t) :: failure
    type(field_meta_t) :: meta
    real(rp), allocatable :: data(:, :, :)
    integer :: i, j, k, stride, direction
    logical :: ok

    do stride = 2, 5
      do direction = 2, 3
        block = cut(N, direction)
        call write_field(t%world, 'strided', block, filled(block), example_meta(), field_form_t('.', 'x', stride=stride), failure)
        coarse%n = strided_points(N, stride)
        coarse%count = coarse%n
        allocate (data(coarse%n(1), coarse%n(2), coarse%n(3)))
        call read_field(t%world, 'strided_x.h5', coarse, data, meta, failure)
        ok = all(coarse%n == (N - 1)/stride + 1) .and. .not. failure%failed
        do k = 1, coarse%n(3)
          do j = 1, coarse%n(2)
            do i = 1, coarse%n(1)
              ok = ok .and. abs(data(i, j, k) - place_value((i - 1)*stride, (j - 1)*stride, &
                                                            (k - 1)*stride)) <= 0
            end do
          end do
        end do
        call t%check('a stride keeps the points whose index is a multiple', ok)
        call t%check('a stride keeps the domain size', abs(meta%domain_size(1) - 2.5_rp) <= 0)
        deallocate (data)
      end do
    end do
  end subroutine test_strides

  subroutine test_plane_runs()
    type(block_t) :: block
    type(failure_t) :: failure
    type(field_meta_t) :: meta
    real(rp), allocatable :: data(:, :, :)
    block = cut([1, 6, 3], 3)
    call write_field(t%world, 'vorx', block, filled(block), example_meta(), field_form_t('.', '000000'), failure)
    allocate (data(1, block%count(2), block%count(3)))
    call read_field(t%world, 'vorx_000000.h5', block, data, meta, failure)
    call t%check('two-dimensional fields have nx = 1', same(data, filled(block)) .and. all(meta%nxyz == [1, &
                                                                                                         6, 3]))
    call t%check('and do not fail',.not. failure%failed)
  end subroutine test_plane_runs

  subroutine test_slices()
    type(block_t) :: block
    type(failure_t) :: failure
    type(hdf5_file_t) :: file
    integer(i8), allocatable :: dims(:)
    integer :: direction, j, k
    real(rp) :: values(N(2)*N(3)), want(N(2), N(3)), time
    do direction = 1, 3
      block = cut(N, direction)
      call write_slice(t%world, 'u1', 4, block, filled(block), example_meta(), field_form_t('.', '000333'), failure)
      call file%open(t%world, 'sliceu1-ix0004_000333.h5', failure)
      call file%dataset_shape('sliceu1-ix0004', dims, failure)
      call t%check('a slice has shape (ny, nz)', all(dims == N(2:)))
      call read_slab(file, 'sliceu1-ix0004', int(N(2:), i8), [0_i8, 0_i8], int(N(2:), i8), values, failure)
      call get_attribute(file, 'sliceu1-ix0004', 'time', time, failure)
      call file%close(failure)
      do k = 1, N(3)
        do j = 1, N(2)
          want(j, k) = place_value(4, j - 1, k - 1)
        end do
      end do
      call t%check('a slice is the plane at ix', all(abs(reshape(values, N(2:)) - want) <= 0) &
                   .and. .not. failure%failed)
      call t%check_close('a slice tells its time', time, 1.0_rp/3, atol=0.0_rp)
    end do
  end subroutine test_slices

  subroutine test_failures()
    type(block_t) :: block
    type(field_meta_t) :: meta
    type(failure_t) :: missing_folder, missing_file, wrong_shape, no_hdf5
    real(rp), allocatable :: data(:, :, :)
    integer :: unit

    block = cut(N, 3)
    call write_field(t%world, 'ux', block, filled(block), example_meta(), &
                     field_form_t('no/such/folder', '0', PRECISION_SINGLE), missing_folder)
    call t%check('a missing folder is a failure', missing_folder%failed)
    call t%check('that names the file', index(missing_folder%reason, 'no/such/folder/ux_0.h5') > 0)

    allocate (data(block%count(1), block%count(2), block%count(3)))
    call read_field(t%world, 'absent_000000.h5', block, data, meta, missing_file)
    call t%check('a missing file is a failure', missing_file%failed)
    call t%check('that says so', index(missing_file%reason, 'absent_000000.h5: does not exist') > 0)
    deallocate (data)

    block = cut([9, 7, 6], 3)
    allocate (data(block%count(1), block%count(2), block%count(3)))
    call read_field(t%world, 'ux_000333.h5', block, data, meta, wrong_shape)
    call t%check('another shape is a failure', wrong_shape%failed)
    call t%check('that names both shapes', index(wrong_shape%reason, '(9, 7, 5), expected (9, 7, 6)') > 0)

    if (t%world%is_root) then
      open (newunit=unit, file='text_000000.h5', status='replace')
      write (unit, '(a)') 'this is not HDF5'
      close (unit)
    end if
    call t%world%barrier()
    call read_field(t%world, 'text_000000.h5', block, data, meta, no_hdf5)
    call t%check('another format is a failure', no_hdf5%failed)
  end subroutine test_failures
end program test_fields
