! SPDX-License-Identifier: GPL-3.0-or-later
!> Two thousand damaged ini files through the reader in one process: each is accepted or refused with
!> messages that name the file, and none stops the program. The damage follows from a seed, which is
!> printed; give another one as the first argument, and the number of files as the second.
program test_ini_fuzz
  use base_errors, only: message_list_t
  use base_kinds, only: rp
  use io_config, only: config_t
  use io_registry, only: registry_t
  use test_ini_sample, only: register_sample, sample_text
  use test_pick, only: picker_t, argument
  use testkit, only: testkit_t
  implicit none
  character(*), parameter :: NL = achar(10)
  type(testkit_t) :: kit
  type(registry_t) :: registry
  type(picker_t) :: random
  integer :: seed, n_files, i, n_accepted, n_refused, n_bad, n_damages(0:11)

  seed = argument(1, 20240607)
  n_files = argument(2, 2000)
  random%state = seed
  write (*, '(a,i0)') 'seed ', seed
  call kit%start(parallel=.false.)
  call register_sample(registry)
  n_accepted = 0
  n_refused = 0
  n_bad = 0
  n_damages = 0
  do i = 1, n_files
    call read_one(damaged())
  end do
  write (*, '(i0,a,i0,a)') n_accepted, ' accepted, ', n_refused, ' refused'
  call kit%check('every file is accepted or refused with messages that name it', &
                 n_bad == 0 .and. n_accepted + n_refused == n_files)
  call kit%check('every kind of damage was done', n_files < 2000 .or. all(n_damages > 50))
  call kit%check('some damage is harmless', n_files < 2000 .or. n_accepted > 50)
  call kit%check('most damage is found', n_refused >= n_accepted)
  call kit%finish()

contains

  !> The sample with one to three damages.
  function damaged() result(text)
    character(:), allocatable :: text
    integer :: d
    text = sample_text()
    do d = 1, random%pick(3)
      call damage(text, random%pick(size(n_damages)) - 1)
    end do
  end function damaged

  subroutine damage(text, kind)
    character(:), allocatable, intent(inout) :: text
    integer, intent(in) :: kind
    character(*), parameter :: DIGITS = '0123456789'
    integer :: a, b, n, other
    n_damages(kind) = n_damages(kind) + 1
    if (len(text) < 10) return
    a = random%pick(len(text) - 1)
    b = min(len(text), a + random%pick(40) - 1)
    select case (kind)
    case (0) ! flip a byte
      text(a:a) = char(ieor(ichar(text(a:a)), random%pick(255)))
    case (1) ! delete a piece
      text = text(:a - 1)//text(b + 1:)
    case (2) ! say a piece twice
      text = text(:b)//text(a:)
    case (3) ! cut off
      text = text(:a)
    case (4) ! swap two lines
      other = random%pick(len(text) - 1)
      call swap_lines(text, min(a, other), max(a, other))
    case (5) ! binary
      text = text(:a)//binary(random%pick(30))//text(a + 1:)
    case (6) ! a huge number where a number stands
      n = scan(text(a:), DIGITS)
      if (n > 0) text = text(:a + n - 1)//repeat('9', random%pick(400))//'e'//repeat('9', random%pick(9))//text(a + n:)
    case (7) ! a very long line
      text = text(:a)//repeat(text(a:b), 10 + random%pick(30000)/(b - a + 1))//text(a + 1:)
    case (8) ! a bracket or another sign of the syntax
      n = random%pick(12)
      text = text(:a)//'[](/)=;#*%.'//char(13)//text(a + 1:)
      text = text(:a)//text(a + n:)
    case (9) ! a bracket is not closed
      n = scan(text(a:), ']/')
      if (n > 0) text = text(:a + n - 2)//text(a + n:)
    case (10) ! other line ends
      n = index(text(a:), NL)
      if (n > 0) text = text(:a + n - 2)//merge(achar(13)//NL, achar(11)//' ', random%pick(2) == 1)//text(a + n:)
    case (11) ! one line out of its place
      n = index(text(a:), NL)
      if (n > 0) text = text(a + n:)//text(:a + n - 1)
    end select
  end subroutine damage

  subroutine swap_lines(text, a, b)
    character(:), allocatable, intent(inout) :: text
    integer, intent(in) :: a, b
    integer :: a1, a2, b1, b2
    a1 = index(text(:a), NL, back=.true.) + 1
    a2 = a + index(text(a + 1:)//NL, NL) - 1
    b1 = index(text(:b), NL, back=.true.) + 1
    b2 = b + index(text(b + 1:)//NL, NL) - 1
    if (b1 <= a2 .or. a2 < a1 .or. b2 < b1) return
    text = text(:a1 - 1)//text(b1:b2)//text(a2 + 1:b1 - 1)//text(a1:a2)//text(b2 + 1:)
  end subroutine swap_lines

  function binary(n) result(bytes)
    integer, intent(in) :: n
    character(n) :: bytes
    integer :: k
    do k = 1, n
      bytes(k:k) = char(random%pick(256) - 1)
    end do
  end function binary

  subroutine read_one(text)
    character(*), intent(in) :: text
    type(config_t) :: c
    type(message_list_t) :: errors, notices
    integer :: e
    logical :: is_good
    call c%load_text(text, 'f.ini', registry, errors, notices, flusi_compat=random%pick(2) == 1)
    is_good = .true.
    do e = 1, errors%count()
      if (.not. names_place(errors%text(e))) is_good = .false.
      if (.not. names_place(errors%text(e))) write (*, '(2a)') 'no place: ', errors%text(e)
    end do
    if (errors%count() == 0) then
      n_accepted = n_accepted + 1
      is_good = values_are_sound(c)
    else
      n_refused = n_refused + 1
    end if
    if (is_good) return
    n_bad = n_bad + 1
  end subroutine read_one

  !> f.ini:line: ..., or what is missing or empty; short, on one line and without control bytes.
  logical function names_place(message) result(holds)
    character(*), intent(in) :: message
    integer :: k, colon
    if (index(message, 'f.ini:') /= 1 .or. len(message) > 1000) then
      holds = .false.
      return
    end if
    colon = 6 + index(message(7:), ':')
    holds = index(message, 'f.ini: [') == 1 .or. index(message, 'f.ini: is empty') == 1
    if (colon > 7) holds = holds .or. verify(message(7:colon - 1), '0123456789') == 0
    do k = 1, len(message)
      if (ichar(message(k:k)) < 32 .or. ichar(message(k:k)) == 127) holds = .false.
    end do
  end function names_place

  !> What was accepted respects the register.
  logical function values_are_sound(c) result(holds)
    type(config_t), intent(in) :: c
    holds = c%get_integer('Resolution', 'nx') >= 1 .and. c%get_integer('Resolution', 'nx') <= 4096 .and. &
            c%get_real('Geometry', 'yl') > 0 .and. c%get_real('Time', 'CFL') > 0 .and. &
            c%get_real('Time', 'CFL') <= 1 .and. c%get_real('Geometry', 'thickness') >= 0 .and. &
            size(c%get_reals('Penalization', 'us_fixed')) == 3 .and. &
            size(c%get_matrix('Wing', 'profile'), 2) == 3 .and. &
            all(abs(c%get_matrix('Wing', 'profile')) <= huge(1.0_rp)) .and. &
            all(c%get_reals('Penalization', 'weights') >= 0)
  end function values_are_sound
end program test_ini_fuzz
