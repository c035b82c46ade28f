! SPDX-License-Identifier: GPL-3.0-or-later
!> Labels every observation of a wing with its load, location and repeat.
module diagnosis_wing_labels
  use base_kinds, only: rp
  use diagnosis_wing_bins, only: bin_rows, bins_t
  use inference_simulator, only: labels_t
  use measurement_experiment, only: experiment_t
  implicit none
  private
  public :: append_surface, make_labels

contains

  !> Returns the labels of all observations: see `labels_t`. A fold is a location: loads of any size at one site have the same fold.
  subroutine make_labels(experiment, bins, labels)
    type(experiment_t), intent(in) :: experiment
    type(bins_t), intent(in) :: bins
    type(labels_t), intent(out) :: labels
    integer :: l, k, n, folds
    n = size(experiment%loads)
    associate (loads => experiment%measurement%loads)
      labels%surface = bins%load(:bins%n)
      labels%site = bins%site(:, :bins%n)
      labels%stage = [(0, l=1, bins%n)]
      allocate (labels%observed(bins%n))
      do l = 1, n
        call bin_rows(bins, l, experiment%comparisons(l)%measured, &
                      labels%observed(bins%first(l):bins%first(l) + bins%count(l) - 1))
      end do
      ! The error of the unloaded scan makes one block of all heights.
      if (any(bins%unloaded(:bins%n) > 0)) then
        labels%block = [(1, l=1, bins%n)]
      else
        labels%block = labels%surface
      end if
      allocate (labels%fold(n), labels%replicate(n), source=0)
      labels%level = [(loads(l)%force*sign(1.0_rp, sum(loads(l)%direction)), l=1, n)]
      labels%order = [(real(loads(l)%order, rp), l=1, n)]
      labels%hold = [(loads(l)%hold, l=1, n)]
      labels%moment = [(loads(l)%force*(loads(l)%point(1) - experiment%root(1)), l=1, n)]
      folds = 0
      do l = 1, n
        labels%replicate(l) = l
        do k = l - 1, 1, -1
          if (norm2(loads(l)%point - loads(k)%point) > 0.02_rp*experiment%model%size) cycle
          labels%fold(l) = labels%fold(k)
          if (abs(loads(l)%force - loads(k)%force) <= 1.0e-6_rp*loads(k)%force .and. &
              norm2(loads(l)%direction - loads(k)%direction) < 1.0e-6_rp) labels%replicate(l) = labels%replicate(k)
        end do
        if (labels%fold(l) > 0) cycle
        folds = folds + 1
        labels%fold(l) = folds
      end do
      if (folds == 1) call fold_by_force(labels)
    end associate
  end subroutine make_labels

  !> Adds n observations at a position [m]: a surface with its own fold and block. They are no response to a load; their `observed`
  !> is 0.
  pure subroutine append_surface(labels, n, site)
    type(labels_t), intent(inout) :: labels
    integer, intent(in) :: n
    real(rp), intent(in) :: site(2)
    integer :: surface, block, k
    surface = size(labels%fold) + 1
    block = max(0, maxval(labels%block)) + 1
    labels%fold = [labels%fold, max(0, maxval(labels%fold)) + 1]
    labels%surface = [labels%surface, (surface, k=1, n)]
    labels%block = [labels%block, (block, k=1, n)]
    labels%observed = [labels%observed, (0.0_rp, k=1, n)]
    labels%site = reshape([labels%site, (site, k=1, n)], [2, size(labels%surface)])
    labels%level = [labels%level, 0.0_rp]
    labels%order = [labels%order, 0.0_rp]
    labels%hold = [labels%hold, -1.0_rp]
    labels%moment = [labels%moment, 0.0_rp]
    labels%replicate = [labels%replicate, surface]
    labels%stage = [labels%stage, (0, k=1, n)]
  end subroutine append_surface

  !> Changes the folds, for loads that all act at one site: each force with its repeats gets its own fold.
  subroutine fold_by_force(labels)
    type(labels_t), intent(inout) :: labels
    integer :: l, k, folds
    folds = 0
    do l = 1, size(labels%fold)
      k = findloc(abs(labels%level(:l) - labels%level(l)) <= 1.0e-6_rp*abs(labels%level(:l)), .true., 1)
      if (k == l) folds = folds + 1
      labels%fold(l) = merge(folds, labels%fold(k), k == l)
    end do
  end subroutine fold_by_force
end module diagnosis_wing_labels
