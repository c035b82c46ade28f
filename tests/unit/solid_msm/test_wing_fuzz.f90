! SPDX-License-Identifier: GPL-3.0-or-later
!> Damaged wing files through the reader in one process: each is accepted or refused with messages that
!> name the file, and none stops the program. Half of them have other values in the datasets, half other
!> bytes anywhere. The damage follows from a seed, which is printed; give another one as the first
!> argument, and the number of files as the second. Bytes are changed in the layout with checksums that our
!> tools write; with a third argument 1 also in the old one, in which HDF5 1.10 itself does not survive all.
program test_wing_fuzz
  use base_errors, only: message_list_t
  use base_kinds, only: rp, i8
  use solid_wing, only: wing_t
  use solid_wing_file, only: read_wing
  use test_pick, only: picker_t, argument
  use testkit, only: testkit_t
  use wing_writer, only: wing_writer_t
  implicit none
  character(*), parameter :: PATH = 'fuzz.h5', WHOLE = 'whole.h5', WHOLE_NEW = 'whole_new.h5'
  type(testkit_t) :: t
  type(picker_t) :: random
  integer :: n_files, with_old, i, n_accepted, n_refused, n_bad

  random%state = argument(1, 20260101)
  n_files = argument(2, 200)
  with_old = argument(3, 0)
  write (*, '(a,i0)') 'seed ', random%state
  call t%start(parallel=.false.)
  call make_whole(WHOLE, .false.)
  call make_whole(WHOLE_NEW, .true.)
  n_accepted = 0
  n_refused = 0
  n_bad = 0
  do i = 1, n_files
    if (modulo(i, 2) == 0) call other_values()
    if (modulo(i, 4) == 1 .and. with_old == 1) call other_bytes(WHOLE)
    if (modulo(i, 4) == 1 .and. with_old /= 1) call other_bytes(WHOLE_NEW)
    if (modulo(i, 4) == 3) call other_bytes(WHOLE_NEW)
    call read_one()
  end do
  write (*, '(i0,a,i0,a)') n_accepted, ' accepted, ', n_refused, ' refused'
  call t%check('every file is accepted or refused with messages that name it', &
               n_bad == 0 .and. n_accepted + n_refused == n_files)
  call t%check('some damage is harmless', n_accepted > 0)
  call t%check('most damage is found', n_refused > n_accepted)
  call t%finish()

contains

  subroutine make_whole(name, is_new)
    character(*), intent(in) :: name
    logical, intent(in) :: is_new
    type(wing_writer_t) :: w
    call w%sample(name, is_new)
    call w%close()
  end subroutine make_whole

  subroutine read_one()
    type(wing_t) :: wing
    type(message_list_t) :: messages
    integer :: k
    call read_wing(PATH, wing, messages)
    if (messages%count() == 0) n_accepted = n_accepted + 1
    if (messages%count() > 0) n_refused = n_refused + 1
    do k = 1, messages%count()
      if (index(messages%text(k), PATH) /= 1 .or. len(messages%text(k)) > 300) n_bad = n_bad + 1
    end do
  end subroutine read_one

  !> The sample with one to three datasets that hold something strange.
  subroutine other_values()
    type(wing_writer_t) :: w
    integer :: k, m, n
    integer, allocatable :: numbers(:)
    real(rp), allocatable :: values(:)
    character(20) :: lists(7) = [character(20) :: '/triangles', '/veins/A/nodes', '/veins/B/nodes', &
                                                         '/veins/C/nodes', '/joints/at_B', '/joints/A-C', '/root/nodes']
    call w%sample(PATH)
    do k = 1, random%pick(3)
      if (random%pick(3) > 1) then
        n = random%pick(6) - 1
        numbers = [(strange_integer(), m=1, 3*n)]
        m = random%pick(size(lists))
        if (m == 1) call w%integers(trim(lists(m)), [3, n], numbers(:3*n))
        if (m > 1) call w%integers(trim(lists(m)), [n], numbers(:n))
      else
        values = [(strange_real(), m=1, 27)]
        if (random%pick(2) == 1) call w%reals('/points', [3, 9], values, is_single=random%pick(2) == 1)
        if (random%pick(2) == 1) call w%reals('/veins/A/diameters', [3], values(:3))
      end if
    end do
    call w%close()
  end subroutine other_values

  integer function strange_integer() result(value)
    integer, parameter :: STRANGE(6) = [0, -1, 10, huge(1), -huge(1), 65536]
    value = random%pick(9)
    if (random%pick(6) == 1) value = STRANGE(random%pick(size(STRANGE)))
  end function strange_integer

  !> Mostly numbers of the right size.
  real(rp) function strange_real() result(value)
    integer(i8), parameter :: BITS(6) = [int(z'7FF0000000000001', i8), int(z'7FF8000000000000', i8), &
                                         int(z'7FF0000000000000', i8), 1_i8, int(z'7FEFFFFFFFFFFFFF', i8), 0_i8]
    value = random%pick(1000)*1e-5_rp
    if (random%pick(100) == 1) value = transfer(BITS(random%pick(size(BITS))), value)
  end function strange_real

  !> A copy of a file with bytes changed, swapped or zeroed, or the end cut off.
  subroutine other_bytes(source)
    character(*), intent(in) :: source
    character, allocatable :: bytes(:)
    integer :: unit, length, k, at, to
    inquire (file=source, size=length)
    allocate (bytes(length))
    open (newunit=unit, file=source, access='stream', form='unformatted', status='old')
    read (unit) bytes
    close (unit)
    do k = 1, random%pick(4)
      at = random%pick(length)
      to = min(length, at + random%pick(40) - 1)
      select case (random%pick(5))
      case (1, 2)
        bytes(at) = char(random%pick(256) - 1)
      case (3)
        bytes(at:to) = char(0)
      case (4)
        bytes(at:to) = bytes(to:at:-1)
      case (5)
        if (random%pick(4) == 1) length = at
      end select
      length = max(1, min(length, size(bytes)))
    end do
    open (newunit=unit, file=PATH, access='stream', form='unformatted', status='replace')
    write (unit) bytes(:length)
    close (unit)
  end subroutine other_bytes
end program test_wing_fuzz
