! SPDX-License-Identifier: GPL-3.0-or-later
!> The XDMF index lists what was saved, and a restarted run continues it. The files it leaves are
!> checked against each other by check_xdmf.py.
program test_xdmf
  use base_errors, only: failure_t
  use base_files, only: remove_file
  use base_kinds, only: rp, i8
  use base_text_lines, only: read_line
  use io_fields, only: field_form_t, field_meta_t, write_field, field_label, PRECISION_SINGLE, PRECISION_DOUBLE
  use io_xdmf, only: xdmf_index_t
  use parallel_block, only: block_t, split_evenly
  use testkit, only: testkit_t
  implicit none
  type(testkit_t) :: t
  character(4), parameter :: PREFIXES(6) = [character(4) :: 'uy', 'ux', 'p', 'uz', 'mask', 'vorx']
  real(rp), parameter :: DOMAIN(3) = [2.0_rp, 3.0_rp, 4.0_rp], ORIGIN(3) = [0.0_rp, -0.5_rp, 0.25_rp]

  call t%start(parallel=.true.)
  call test_restart()
  call save_run('coarse', [8, 9, 10], 3, PRECISION_DOUBLE, [0.0_rp, 0.5_rp])
  call save_run('plane', [1, 12, 10], 1, PRECISION_SINGLE, [0.0_rp, 0.5_rp])
  call test_surface()
  call test_failures()
  call t%finish()

contains

  !> Saves fields named <run>ux etc. at some times, with an index; `restart` continues an index.
  subroutine save_run(run, n, stride, precision, times, restart)
    character(*), intent(in) :: run
    integer, intent(in) :: n(3), stride, precision
    real(rp), intent(in) :: times(:)
    real(rp), intent(in), optional :: restart
    type(xdmf_index_t) :: xdmf
    type(block_t) :: block
    type(field_meta_t) :: meta
    type(field_form_t) :: form
    type(failure_t) :: failure
    real(rp), allocatable :: data(:, :, :)
    character(16) :: names(size(PREFIXES))
    integer :: i, c, k, j, ix

    names = run//PREFIXES
    block%n = n
    block%count = n
    call split_evenly(n(3), t%world%size, t%world%rank, block%start(3), block%count(3))
    allocate (data(block%count(1), block%count(2), block%count(3)))
    meta%domain_size = DOMAIN
    meta%origin = ORIGIN
    meta%nxyz = n
    call xdmf%open(t%world, run//'.xmf', failure, restart)
    do i = 1, size(times)
      meta%time = times(i)
      form = field_form_t('.', field_label(times(i), 0_i8, 'time'), precision, stride)
      do c = 1, size(PREFIXES)
        do k = 1, block%count(3)
          do j = 1, block%count(2)
            do ix = 1, block%count(1)
              data(ix, j, k) = 1000*c + ix - 1 + 10*(j - 1) + 100*(k - 1 + block%start(3)) + times(i)
            end do
          end do
        end do
        call write_field(t%world, trim(names(c)), block, data, meta, form, failure)
      end do
      call xdmf%add(names, meta, form, failure)
    end do
    call t%check('fields and index of '//run//' are written',.not. failure%failed)
  end subroutine save_run

  !> Number of lines of a file that contain `text`.
  integer function occurrences(path, text) result(n)
    character(*), intent(in) :: path, text
    character(:), allocatable :: line
    integer :: unit
    logical :: found
    call t%world%barrier()
    n = 0
    open (newunit=unit, file=path, status='old', action='read')
    do
      call read_line(unit, line, found)
      if (.not. found) exit
      if (index(line, text) > 0) n = n + 1
    end do
    close (unit)
    call t%world%barrier()
  end function occurrences

  subroutine test_restart()
    call save_run('run', [6, 7, 5], 1, PRECISION_SINGLE, [0.0_rp, 0.25_rp, 0.5_rp, 0.75_rp])
    call t%check('the index has one grid a save', occurrences('run.xmf', 'GridType="Uniform"') == 4)
    call save_run('run', [6, 7, 5], 1, PRECISION_SINGLE, [0.5_rp, 1.0_rp], restart=0.5_rp)
    call t%check('a restart keeps earlier grids and replaces later ones', &
                 occurrences('run.xmf', 'GridType="Uniform"') == 4 .and. occurrences('run.xmf', &
                                                                                     '000750') == 0 .and. &
                 occurrences('run.xmf', 'runp_000500.h5:/runp') == 1 .and. occurrences('run.xmf', &
                                                                                       'runp_001000.h5') == 1)
    call t%check('ux, uy and uz are one vector', occurrences('run.xmf', &
                                                             'Name="runu" AttributeType="Vector"') == 4)
    call t%check('and three scalars', occurrences('run.xmf', 'Name="runuz" AttributeType="Scalar"') == 4)
    call t%check('a component alone is only a scalar', occurrences('run.xmf', &
                                                                   'AttributeType="Vector"') == 4 .and. &
                 occurrences('run.xmf', 'Name="runvorx" AttributeType="Scalar"') == 4)
    call save_run('kept', [4, 4, 4], 1, PRECISION_SINGLE, [0.0_rp, 0.5_rp, 0.75_rp])
    call save_run('kept', [4, 4, 4], 1, PRECISION_SINGLE, [1.0_rp], restart=0.5_rp)
    call t%check('of an earlier run the grids before the restart stay', occurrences('kept.xmf', 'GridType="Uniform"') == 2 .and. &
                 occurrences('kept.xmf', 'keptp_000000.h5:/keptp') == 1 .and. occurrences('kept.xmf', 'keptp_000500.h5') == 0)
    if (t%world%is_root) call remove_file('again.xmf') ! of an earlier run of this test
    call t%world%barrier()
    call save_run('again', [4, 4, 4], 1, PRECISION_SINGLE, [0.5_rp], restart=0.5_rp)
    call t%check('a missing index begins at the restart', occurrences('again.xmf', 'GridType="Uniform"') == 1)
    call save_run('again', [4, 4, 4], 1, PRECISION_SINGLE, [0.0_rp])
    call t%check('a fresh start forgets an old index', occurrences('again.xmf', 'GridType="Uniform"') == 1 &
                 .and. &
                 occurrences('again.xmf', '000500') == 0)
  end subroutine test_restart

  !> A surface has one grid a save, of the sizes of that time; a restart continues the index.
  subroutine test_surface()
    type(xdmf_index_t) :: xdmf
    type(failure_t) :: failure
    call xdmf%open(t%world, 'wing.xmf', failure)
    call xdmf%add_surface(0.0_rp, '000000', 'wing_000000.h5', [12, 10], ['velocities', 'forces    '], failure)
    call xdmf%add_surface(0.5_rp, '000500', 'wing_000500.h5', [13, 11], ['velocities', 'forces    '], failure)
    call t%check('a surface can be added',.not. failure%failed)
call t%check('with its triangles', occurrences('wing.xmf', '<Topology TopologyType="Triangle" NumberOfElements="10">') &
                 == 1 .and. occurrences('wing.xmf', 'Dimensions="11 3">wing_000500.h5:/triangles') == 1)
    call t%check('which are integers of 32 bits', occurrences('wing.xmf', 'NumberType="Int" Precision="4"') == 2)
    call t%check('its points', occurrences('wing.xmf', 'Precision="8" Dimensions="12 3">wing_000000.h5:/points') == 1 .and. &
                 occurrences('wing.xmf', '<Geometry GeometryType="XYZ">') == 2)
    call t%check('and its vectors', occurrences('wing.xmf', 'Name="forces" AttributeType="Vector" Center="Node"') == 2 &
                 .and. occurrences('wing.xmf', 'Dimensions="13 3">wing_000500.h5:/velocities') == 1)
    call xdmf%add_surface(0.7_rp, '000700', 'wing_000700.h5', [17, 16], ['velocities'], failure, ['jump'])
    call t%check('scalars belong to triangles', occurrences('wing.xmf', &
                             '<Attribute Name="jump" AttributeType="Scalar" Center="Cell">') == 1 .and. &
                 occurrences('wing.xmf', 'Precision="8" Dimensions="16">wing_000700.h5:/jump') == 1)
    call xdmf%open(t%world, 'wing.xmf', failure, restart_time=0.5_rp)
    call xdmf%add_surface(0.5_rp, '000500', 'wing_000500.h5', [14, 11], ['velocities'], failure)
    call t%check('a restart keeps earlier surfaces and replaces later ones', occurrences('wing.xmf', &
                              'GridType="Uniform"') == 2 .and. occurrences('wing.xmf', 'Dimensions="13 3"') == 0 .and. &
                 occurrences('wing.xmf', 'Dimensions="14 3"') == 2)
    call xdmf%add_surface(0.6_rp, '000500', 'wing_000500.h5', [15, 11], ['velocities'], failure)
    call t%check('a surface of the same label is replaced', occurrences('wing.xmf', 'Dimensions="14 3"') == 0 .and. &
                 occurrences('wing.xmf', 'Dimensions="15 3"') == 2)
  end subroutine test_surface

  subroutine test_failures()
    type(xdmf_index_t) :: xdmf
    type(failure_t) :: missing, foreign
    integer :: unit
    call xdmf%open(t%world, 'no/such/folder/x.xmf', missing)
    call xdmf%add(['p'], field_meta_t(nxyz=[4, 4, 4]), field_form_t('.', '000000'), missing)
    call t%check('a missing folder is a failure', missing%failed)
    if (missing%failed) call t%check('that names the index', index(missing%reason, 'no/such/folder/x.xmf: cannot be written') == 1)
    if (t%world%is_root) then
      open (newunit=unit, file='foreign.xmf', status='replace')
      write (unit, '(a)') 'something else'
      close (unit)
    end if
    call t%world%barrier()
    call xdmf%open(t%world, 'foreign.xmf', foreign, restart_time=1.0_rp)
    call t%check('a file of another kind is a failure', foreign%failed)
    if (foreign%failed) call t%check('that names it', foreign%reason == 'foreign.xmf: was not written by this program: '// &
                                     'move it away')
  end subroutine test_failures
end program test_xdmf
