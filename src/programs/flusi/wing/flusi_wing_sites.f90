! SPDX-License-Identifier: GPL-3.0-or-later
!> Reads forces at named sites. For example, 'tip 0 0 1e-4 + vein:C:last 0 0 2e-5, joint:C_Sc 0 0 1e-4' lists two groups, the first
!> of which has two forces. PLACE_HELP explains the names of sites.
module flusi_wing_sites
  use base_errors, only: failure_t, message_list_t
  use base_kinds, only: rp
  use base_text, only: BLANKS, next_word, number_text, parse_integer, parse_real, quoted
  use common_words, only: find_words
  use io_config, only: config_t
  use solid_loads, only: load_t
  use solid_wing_case, only: wing_case_t
  implicit none
  private
  public :: point_force_t, force_group_t, read_force_groups, add_force

  !> Holds a point of the wing, or a point in a triangle by its corners and their fractions.
  type :: site_t
    integer :: n = 0
    integer :: points(3) = 0
    real(rp) :: weights(3) = 0
  end type site_t

  !> Holds a force and its site.
  type :: point_force_t
    type(site_t) :: site
    real(rp) :: force(3) = 0 !< [N]
  end type point_force_t

  !> Holds forces that act at the same time.
  type :: force_group_t
    type(point_force_t), allocatable :: forces(:)
  end type force_group_t

contains

  !> Adds `factor` times this force to forces(3, n_all) [N], distributed among the points of its site.
  pure subroutine add_force(self, factor, forces)
    type(point_force_t), intent(in) :: self
    real(rp), intent(in) :: factor
    real(rp), intent(inout) :: forces(:, :)
    integer :: i
    do i = 1, self%site%n
      associate (p => self%site%points(i))
        forces(:, p) = forces(:, p) + (factor*self%site%weights(i))*self%force
      end associate
    end do
  end subroutine add_force

  !> Reads the groups that `text`, the value of [section] key, lists. Adds all mistakes to `errors`.
  subroutine read_force_groups(config, section, key, text, s, groups, errors)
    type(config_t), intent(in) :: config
    character(*), intent(in) :: section, key, text
    type(wing_case_t), intent(in) :: s
    type(force_group_t), allocatable, intent(out) :: groups(:)
    type(message_list_t), intent(inout) :: errors
    character(:), allocatable :: problems
    integer :: position, first, last, n
    logical :: found
    problems = ''
    n = 0
    allocate (groups(count([(text(position:position) == ',', position=1, len(text))]) + 1))
    position = 1
    do
      call next_word(text, ',', position, first, last, found)
      if (.not. found) exit
      if (verify(text(first:last), BLANKS) == 0) cycle
      n = n + 1
      call read_group(text(first:last), s, groups(n), problems)
    end do
    groups = groups(:n)
    if (len(problems) > 0) call config%complain(errors, section, key, problems(3:))
  end subroutine read_force_groups

  !> Reads forces that act at the same time, separated by '+'. Adds their mistakes to `problems`.
  subroutine read_group(text, s, group, problems)
    character(*), intent(in) :: text
    type(wing_case_t), intent(in) :: s
    type(force_group_t), intent(out) :: group
    character(:), allocatable, intent(inout) :: problems
    character(:), allocatable :: problem
    type(point_force_t) :: one
    integer :: position, begin, first, last
    logical :: found
    allocate (group%forces(0))
    position = 1
    begin = 1
    do
      call next_word(text, BLANKS, position, first, last, found)
      if (found) then
        if (text(first:last) /= '+') cycle
      else
        first = len(text) + 1
      end if
      call read_force(text(begin:first - 1), s, one, problem)
      group%forces = [group%forces, one]
      if (allocated(problem)) problems = problems//'; '//problem
      if (.not. found) exit
      begin = last + 1
    end do
  end subroutine read_group

  !> Reads one force, SITE FX FY FZ. `problem` says what is wrong with it.
  subroutine read_force(text, s, force, problem)
    character(*), intent(in) :: text
    type(wing_case_t), intent(in) :: s
    type(point_force_t), intent(out) :: force
    character(:), allocatable, intent(out) :: problem
    integer :: first(5), last(5), i, n
    call find_words(text, first, last, n)
    if (n /= 4) then
      problem = quoted(trim(adjustl(text)))//' is not SITE FX FY FZ, a site of the wing and three components of a force'
      return
    end if
    call find_site(text(first(1):last(1)), s, force%site, problem)
    if (allocated(problem)) return
    do i = 1, 3
      call parse_real(text(first(i + 1):last(i + 1)), force%force(i), problem)
      if (allocated(problem)) return
    end do
    if (.not. any(abs(force%force) > 0)) then
      problem = quoted(trim(adjustl(text)))//': the force is zero'
    else if (all(s%model%free(force%site%points(:force%site%n)) == 0)) then
      problem = quoted(trim(adjustl(text)))//': the force acts on the clamped root only'
    end if
  end subroutine read_force

  !> Finds the site called `name`. Sets `problem` if there is none.
  subroutine find_site(name, s, site, problem)
    character(*), intent(in) :: name
    type(wing_case_t), intent(in) :: s
    type(site_t), intent(out) :: site
    character(:), allocatable, intent(inout) :: problem
    integer :: colon, point
    colon = index(name, ':')
    point = 0
    if (name == 'tip') then
      point = s%tip
    else if (colon == 0) then
      problem = quoted(name)//' is no site of the wing; valid: tip, vein:NAME:first, vein:NAME:last, vein:NAME:K, joint:NAME, '// &
                'point:K, at:X:Y'
    else
      select case (name(:colon - 1))
      case ('point')
        call find_number(name(colon + 1:), s%model%n_points, point, problem)
      case ('joint')
        call find_joint(name(colon + 1:), s, point, problem)
      case ('vein')
        call find_on_vein(name(colon + 1:), s, point, problem)
      case ('at')
        call find_at(name(colon + 1:), s, site, problem)
        return
      case default
        problem = quoted(name)//' is no site of the wing; valid: tip, vein:NAME:first, vein:NAME:last, vein:NAME:K, '// &
                  'joint:NAME, point:K, at:X:Y'
      end select
    end if
    site = site_t(n=1, points=[point, 0, 0], weights=[1.0_rp, 0.0_rp, 0.0_rp])
  end subroutine find_site

  !> Reads the number of a point, 1 to `largest`. `problem` says what is wrong with it; `number` is 1 then.
  subroutine find_number(text, largest, number, problem)
    character(*), intent(in) :: text
    integer, intent(in) :: largest
    integer, intent(out) :: number
    character(:), allocatable, intent(inout) :: problem
    call parse_integer(text, number, problem)
    if (.not. allocated(problem) .and. (number < 1 .or. number > largest)) &
      problem = number_text(number)//' is no point; valid: 1 to '//number_text(largest)
    if (allocated(problem)) number = 1
  end subroutine find_number

  !> Finds the point of the joint `name`. `problem` says if there is none; `point` is 1 then.
  subroutine find_joint(name, s, point, problem)
    character(*), intent(in) :: name
    type(wing_case_t), intent(in) :: s
    integer, intent(out) :: point
    character(:), allocatable, intent(inout) :: problem
    character(:), allocatable :: names
    integer :: i
    point = 1
    names = ''
    do i = 1, size(s%wing%joints)
      names = names//' | '//s%wing%joints(i)%name
      if (s%wing%joints(i)%name /= name) cycle
      point = s%wing%joints(i)%nodes(2)
      return
    end do
    problem = 'there is no joint '//quoted(name)//'; valid: '//names(min(4, len(names) + 1):)
  end subroutine find_joint

  !> Finds a site of the form NAME:first, NAME:last or NAME:K.
  subroutine find_on_vein(text, s, point, problem)
    character(*), intent(in) :: text
    type(wing_case_t), intent(in) :: s
    integer, intent(out) :: point
    character(:), allocatable, intent(inout) :: problem
    character(:), allocatable :: names
    integer :: i, k, colon
    point = 1
    names = ''
    colon = index(text, ':')
    if (colon == 0) colon = len(text) + 1
    do i = 1, size(s%wing%veins)
      associate (vein => s%wing%veins(i))
        names = names//' | '//vein%name
        if (vein%name /= text(:colon - 1)) cycle
        if (colon > len(text)) then
          problem = 'where on vein '//vein%name//'? valid: vein:'//vein%name//':first, :last or :K'
        else if (text(colon + 1:) == 'first') then
          point = vein%nodes(1)
        else if (text(colon + 1:) == 'last') then
          point = vein%nodes(size(vein%nodes))
        else
          call find_number(text(colon + 1:), size(vein%nodes), k, problem)
          point = vein%nodes(k)
        end if
        return
      end associate
    end do
    problem = 'there is no vein '//quoted(text(:colon - 1))//'; valid: '//names(min(4, len(names) + 1):)
  end subroutine find_on_vein

  !> Finds a site of the form X:Y. It is distributed among the corners of its triangle.
  subroutine find_at(text, s, site, problem)
    character(*), intent(in) :: text
    type(wing_case_t), intent(in) :: s
    type(site_t), intent(inout) :: site
    character(:), allocatable, intent(inout) :: problem
    type(load_t) :: load
    type(failure_t) :: failure
    real(rp) :: xy(2)
    integer :: colon, i
    site%points(1) = 1
    site%n = 1
    colon = index(text, ':')
    if (colon == 0) then
      problem = quoted('at:'//text)//' needs two coordinates, at:X:Y'
      return
    end if
    call parse_real(text(:colon - 1), xy(1), problem)
    if (.not. allocated(problem)) call parse_real(text(colon + 1:), xy(2), problem)
    if (allocated(problem)) return
    call load%init(s%model)
    call load%add_at(s%model, xy, [1.0_rp, 0.0_rp, 0.0_rp], failure)
    if (failure%failed) then
      problem = 'the place '//number_text(xy(1))//' '//number_text(xy(2))//' m is not on the membrane'
      return
    end if
    site%n = 0
    do i = 1, s%model%n_points
      if (.not. abs(load%force(1, i)) > 0) cycle
      site%n = site%n + 1
      site%points(site%n) = i
      site%weights(site%n) = load%force(1, i)
    end do
  end subroutine find_at
end module flusi_wing_sites
