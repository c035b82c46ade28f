! SPDX-License-Identifier: GPL-3.0-or-later
!> Writes values of visited types into a checkpoint and reads them, each component under its name.
!>
!> One real is a number of the file, or a table of one if `reals_are_tables`; an array is a table in the order of its elements.
!> Integers and logicals are integers of the file, arrays of them tables.
module io_checkpoint_values
  use base_errors, only: failure_t, require
  use base_kinds, only: i8, rp
  use base_text, only: number_text
  use base_visitor, only: visited_t, visitor_t
  use io_checkpoint, only: checkpoint_reader_t, checkpoint_writer_t
  implicit none
  private
  public :: checkpoint_saver_t, checkpoint_loader_t, save_part, load_part

  integer(i8), parameter :: MOST_EXACT = 2_i8**53 !< integers up to it are reals without error

  !> Puts what it visits into an open checkpoint. Visits are collective.
  type, extends(visitor_t) :: checkpoint_saver_t
    private
    type(checkpoint_writer_t), pointer :: writer => null()
    logical :: reals_are_tables = .false.
  contains
    procedure :: begin => saver_begin
    procedure :: carry_real => saver_real
    procedure :: carry_reals => saver_reals
    procedure :: carry_integer => saver_integer
    procedure :: carry_integers => saver_integers
    procedure :: carry_text => saver_text
  end type checkpoint_saver_t

  !> Sets the components that it visits to the values of an open checkpoint. Visits are collective. `failure` says which value is
  !> missing or has another size.
  type, extends(visitor_t) :: checkpoint_loader_t
    private
    type(checkpoint_reader_t), pointer :: reader => null()
    logical :: reals_are_tables = .false.
  contains
    procedure :: begin => loader_begin
    procedure :: carry_real => loader_real
    procedure :: carry_reals => loader_reals
    procedure :: carry_integer => loader_integer
    procedure :: carry_integers => loader_integers
    procedure :: carry_text => loader_text
  end type checkpoint_loader_t

contains

  !> Begins to save. All names will begin with `prefix`. The writer must outlive the visits.
  subroutine saver_begin(self, writer, prefix, reals_are_tables)
    class(checkpoint_saver_t), intent(out) :: self
    type(checkpoint_writer_t), intent(inout), target :: writer
    character(*), intent(in) :: prefix
    logical, intent(in), optional :: reals_are_tables
    self%writer => writer
    self%path = prefix
    if (present(reals_are_tables)) self%reals_are_tables = reals_are_tables
  end subroutine saver_begin

  !> Writes one real, as a table of one if reals are tables.
  subroutine saver_real(self, name, value)
    class(checkpoint_saver_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: value
    if (self%reals_are_tables) then
      call self%writer%put_reals(name, [value])
    else
      call self%writer%put_real(name, value)
    end if
  end subroutine saver_real

  !> Writes a table of reals.
  subroutine saver_reals(self, name, values)
    class(checkpoint_saver_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: values(:)
    call self%writer%put_reals(name, values)
  end subroutine saver_reals

  !> Writes one integer.
  subroutine saver_integer(self, name, value)
    class(checkpoint_saver_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: value
    call self%writer%put_integer(name, value)
  end subroutine saver_integer

  !> Writes integers as a table of reals. Integers that a real cannot hold exactly stop the program.
  subroutine saver_integers(self, name, values)
    class(checkpoint_saver_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: values(:)
    call require(all(abs(values) <= MOST_EXACT), 'io_checkpoint_values: integers that are exact as reals in '//name)
    call self%writer%put_reals(name, real(values, rp))
  end subroutine saver_integers

  !> Writes a text.
  subroutine saver_text(self, name, text)
    class(checkpoint_saver_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(inout) :: text
    call self%writer%put_text(name, text)
  end subroutine saver_text

  !> Begins to load, with the arguments of `begin` of the saver that wrote the values.
  subroutine loader_begin(self, reader, prefix, reals_are_tables)
    class(checkpoint_loader_t), intent(out) :: self
    type(checkpoint_reader_t), intent(inout), target :: reader
    character(*), intent(in) :: prefix
    logical, intent(in), optional :: reals_are_tables
    self%is_reading = .true.
    self%reader => reader
    self%path = prefix
    if (present(reals_are_tables)) self%reals_are_tables = reals_are_tables
  end subroutine loader_begin

  !> Reads one real. A value that is missing is a failure.
  subroutine loader_real(self, name, value)
    class(checkpoint_loader_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: value
    real(rp) :: values(1)
    if (self%reals_are_tables) then
      values = 0
      call self%carry_reals(name, values)
      value = values(1)
    else
      call self%reader%get_real(name, value, self%failure)
    end if
  end subroutine loader_real

  !> Reads a table of reals. A table that is missing, or has another size, is a failure.
  subroutine loader_reals(self, name, values)
    class(checkpoint_loader_t), intent(inout) :: self
    character(*), intent(in) :: name
    real(rp), intent(inout) :: values(:)
    real(rp), allocatable :: stored(:)
    call self%reader%get_reals(name, stored, self%failure)
    if (self%failure%failed) return
    if (size(stored) /= size(values)) then
      call self%failure%raise('the checkpoint has '//number_text(size(stored))//' numbers in '//name//' instead of '// &
                              number_text(size(values)))
    else
      values = stored
    end if
  end subroutine loader_reals

  !> Reads one integer. A value that is missing is a failure.
  subroutine loader_integer(self, name, value)
    class(checkpoint_loader_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: value
    call self%reader%get_integer(name, value, self%failure)
  end subroutine loader_integer

  !> Reads integers from a table of reals. A table that is missing, or has another size, is a failure.
  subroutine loader_integers(self, name, values)
    class(checkpoint_loader_t), intent(inout) :: self
    character(*), intent(in) :: name
    integer(i8), intent(inout) :: values(:)
    real(rp) :: stored(size(values))
    stored = 0
    call self%carry_reals(name, stored)
    if (self%failure%failed) return
    if (.not. all(abs(stored) <= MOST_EXACT)) then
      call self%failure%raise('the checkpoint has no integers in '//name)
    else
      values = nint(stored, i8)
    end if
  end subroutine loader_integers

  !> Reads a text. A text that is missing is a failure.
  subroutine loader_text(self, name, text)
    class(checkpoint_loader_t), intent(inout) :: self
    character(*), intent(in) :: name
    character(:), allocatable, intent(inout) :: text
    call self%reader%get_text(name, text, self%failure)
  end subroutine loader_text

  !> Writes a part, whose values have names that begin with `prefix` and whose reals are tables.
  subroutine save_part(writer, prefix, part)
    type(checkpoint_writer_t), intent(inout), target :: writer
    character(*), intent(in) :: prefix
    class(visited_t), intent(inout) :: part
    type(checkpoint_saver_t) :: saver
    call saver%begin(writer, prefix, reals_are_tables=.true.)
    call part%visit(saver)
  end subroutine save_part

  !> Reads a part, whose values have names that begin with `prefix` and whose reals are tables. Does nothing after a failure.
  subroutine load_part(reader, prefix, part, failure)
    type(checkpoint_reader_t), intent(inout), target :: reader
    character(*), intent(in) :: prefix
    class(visited_t), intent(inout) :: part
    type(failure_t), intent(inout) :: failure
    type(checkpoint_loader_t) :: loader
    if (failure%failed) return
    call loader%begin(reader, prefix, reals_are_tables=.true.)
    call part%visit(loader)
    if (loader%failure%failed) call failure%raise(loader%failure%reason)
  end subroutine load_part
end module io_checkpoint_values
