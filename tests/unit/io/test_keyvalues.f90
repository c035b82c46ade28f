! SPDX-License-Identifier: GPL-3.0-or-later
!> Key values against numbers worked out by hand.
program test_keyvalues
  use, intrinsic :: iso_fortran_env, only: output_unit
  use base_errors, only: failure_t
  use base_files, only: make_folder
  use base_kinds, only: rp
  use base_text_lines, only: read_line
  use io_fields, only: field_form_t, field_meta_t, write_field
  use io_keyvalues, only: field_keys, keyvalues, read_keys, compare_keys, write_verdict, N_KEYS
  use parallel_block, only: block_t
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t

  call t%start(parallel=.true.) ! field files are written in parallel
  call test_by_hand()
  call test_strided()
  call test_files()
  call t%finish()

contains

  subroutine write_example(name, n, stride, domain)
    character(*), intent(in) :: name
    integer, intent(in) :: n(3), stride
    real(rp), intent(in) :: domain(3)
    type(block_t) :: block
    type(field_meta_t) :: meta
    type(failure_t) :: failure
    real(rp) :: data(n(1), n(2), n(3))
    integer :: i, j, k
    do k = 1, n(3)
      do j = 1, n(2)
        do i = 1, n(1)
          data(i, j, k) = (i - 1) - 2*(j - 1) + 4*(k - 1)
        end do
      end do
    end do
    block%n = n
    block%count = n
    meta%time = 0.5_rp
    meta%domain_size = domain
    call write_field(t%world, name, block, data, meta, field_form_t('.', '000500', stride=stride), failure)
    call t%check('the example is written',.not. failure%failed)
  end subroutine write_example

  !> A grid of 2 x 2 x 2 points with spacings 1, 2 and 3: f = i - 2 j + 4 k takes the values
  !> 0 1 -2 -1 4 5 2 3, and x + y + z the values 0 1 2 3 3 4 5 6.
  subroutine test_by_hand()
    real(rp) :: keys(N_KEYS)
    type(failure_t) :: failure
    call write_example('ux', [2, 2, 2], 1, [2.0_rp, 4.0_rp, 6.0_rp])
    call field_keys('ux_000500.h5', keys, failure)
    call t%check('the key of a field can be had',.not. failure%failed)
    call t%check_close('time', keys(1), 0.5_rp, atol=0.0_rp)
    call t%check_close('maximum', keys(2), 5.0_rp, atol=0.0_rp)
    call t%check_close('minimum', keys(3), -2.0_rp, atol=0.0_rp)
    call t%check_close('mean', keys(4), 12.0_rp/8, rtol=1.0e-14_rp)
    call t%check_close('mean square', keys(5), 60.0_rp/8, rtol=1.0e-14_rp)
    call t%check_close('mean (x+y+z) f', keys(6), 54.0_rp/8, rtol=1.0e-14_rp)
  end subroutine test_by_hand

  !> Every second of 4 points along each side of the same box is the same field times 2.
  subroutine test_strided()
    real(rp) :: keys(N_KEYS), want(N_KEYS)
    type(failure_t) :: failure
    call field_keys('ux_000500.h5', want, failure)
    call write_example('uy', [4, 4, 4], 2, [2.0_rp, 4.0_rp, 6.0_rp])
    call field_keys('uy_000500.h5', keys, failure)
    call t%check('a strided field has its own spacing', all(abs(keys - [0.5_rp, 2*want(2:4), 4*want(5), &
                                                                        2*want(6)]) &
                                                            < 1.0e-13_rp))
    call write_example('vorx', [1, 4, 3], 1, [1.0_rp, 4.0_rp, 3.0_rp])
    call field_keys('vorx_000500.h5', keys, failure)
    call t%check_close('a plane has a key too', keys(4), (-12.0_rp*3 + 12*4)/12, rtol=1.0e-14_rp)
    call t%check('without failure',.not. failure%failed)
  end subroutine test_strided

  subroutine test_files()
    type(failure_t) :: failure, missing, nonsense, there, taken
    character(:), allocatable :: line
    real(rp) :: keys(N_KEYS)
    logical :: ok, found
    integer :: unit

    open (newunit=unit, status='scratch', action='readwrite')
    call keyvalues('ux_000500.h5', unit, failure)
    rewind (unit)
    call read_line(unit, line, found)
    call t%check('the key is printed as one line', line == &
                 ' 5.00000000E-01  5.00000000E+00 -2.00000000E+00'// &
                 '  1.50000000E+00  7.50000000E+00  6.75000000E+00')
    call read_keys('ux_000500.key', keys, failure)
    call t%check('and written beside the field',.not. failure%failed .and. abs(keys(6) - 6.75_rp) <= 0)

    call compare('ok.key', [1.00009_rp, 1.0_rp, 1.0_rp, 0.99991_rp, 9.0e-5_rp, -1.0_rp], &
                 [1.0_rp, 1.0_rp, 1.0_rp, 1.0_rp, 0.9e-7_rp, -1.0_rp], unit, ok)
    call t%check('differences within the tolerance are accepted', ok)
    call compare('off.key', [1.0_rp, 1.0_rp, 1.0_rp, 1.0_rp, 1.0_rp, 1.00011_rp], spread(1.0_rp, 1, 6), &
                 unit, ok)
    call t%check('a relative difference of 1.1e-4 is not',.not. ok)
    call compare('tiny.key', [1.0_rp, 1.0_rp, 1.0_rp, 1.0_rp, 1.2e-7_rp, 1.0_rp], &
                 [1.0_rp, 1.0_rp, 1.0_rp, 1.0_rp, 1.1e-7_rp, 1.0_rp], unit, ok)
    call t%check('relative from a reference of 1e-7 on',.not. ok)
    call compare('zero.key', [1.0_rp, 1.0_rp, 1.0_rp, 1.0_rp, 1.1e-4_rp, 1.0_rp], &
                 [1.0_rp, 1.0_rp, 1.0_rp, 1.0_rp, 0.0_rp, 1.0_rp], unit, ok)
    call t%check('absolute below',.not. ok)
    open (newunit=unit, file='nan.key', status='replace')
    write (unit, '(a)') '0.0 NaN 0.0 0.0 0.0 0.0'
    close (unit)
    open (newunit=unit, status='scratch', action='readwrite')
    call compare_keys('nan.key', 'nan.key', unit, ok, failure)
    call t%check('NaN agrees with nothing',.not. ok)
    call compare_keys('absent.key', 'nan.key', unit, ok, missing)
    call t%check('a missing key is a failure', missing%failed .and. .not. ok)
    close (unit)
    open (newunit=unit, file='bad.key', status='replace')
    write (unit, '(a)') '1.0 2.0 three'
    close (unit)
    call read_keys('bad.key', keys, nonsense)
    call t%check('a file of something else is a failure', nonsense%failed)

    call write_verdict(.false., failure)
    open (newunit=unit, file='return', status='old')
    call read_line(unit, line, found)
    close (unit, status='delete')
    call t%check('the verdict file holds the exit code', line == '1' .and. .not. failure%failed)
    call make_folder('vorx_000500.key', there) ! perhaps of an earlier run of this test
    call keyvalues('vorx_000500.h5', output_unit, taken)
    call t%check('a key that cannot be written is a failure', taken%failed)
    if (taken%failed) call t%check('that names its file', index(taken%reason, 'vorx_000500.key: cannot be written') == 1)
    call field_keys('absent_000000.h5', keys, missing)
    call t%check('a missing field is a failure', missing%failed)
  end subroutine test_files

  subroutine compare(name, keys, reference, unit, ok)
    character(*), intent(in) :: name
    real(rp), intent(in) :: keys(N_KEYS), reference(N_KEYS)
    integer, intent(in) :: unit
    logical, intent(out) :: ok
    type(failure_t) :: failure
    call save(name, keys)
    call save(name//'.ref', reference)
    call compare_keys(name, name//'.ref', unit, ok, failure)
    call t%check('keys can be compared',.not. failure%failed)
  end subroutine compare

  subroutine save(name, keys)
    character(*), intent(in) :: name
    real(rp), intent(in) :: keys(N_KEYS)
    integer :: unit
    open (newunit=unit, file=name, status='replace')
    write (unit, '(6(es15.8,1x))') keys
    close (unit)
  end subroutine save
end program test_keyvalues
