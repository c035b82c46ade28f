# SPDX-License-Identifier: GPL-3.0-or-later
# ruff: noqa: F403, F405
"""For Spack: add the folder packaging/spack as a repository (repo.yaml), then `spack dev-build flusi-msm@main` in the source."""
from spack.package import *


class FlusiMsm(CMakePackage):
    """Flow around insects with flexible wings: pseudo-spectral solver, training and diagnosis of mass-spring wings."""

    license("GPL-3.0-or-later")

    version("main")  # of a source that is there: spack dev-build

    variant("native", default=False, description="Compile for this very machine")
    variant("tools", default=True, description="Python for the tools: wings, pictures, reports")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("fortran", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi")
    depends_on("fftw@3.3: ~mpi precision=double")
    depends_on("hdf5@1.10: +mpi +fortran")
    depends_on("blas")
    depends_on("lapack")
    depends_on("suite-sparse")
    with when("+tools"):
        depends_on("python@3.9:", type=("build", "run"))
        depends_on("py-numpy@1.24:2", type="run")
        depends_on("py-h5py@3.7:3", type="run")
        depends_on("py-matplotlib@3.6:3", type="run")
        depends_on("py-scipy@1.10:1", type="run")
        depends_on("py-pillow@9:", type="run")
        depends_on("py-pandas@1.5:", type="run")

    generator("ninja")

    def cmake_args(self):
        return [self.define_from_variant("FLUSI_NATIVE", "native"), self.define("FLUSI_TESTS", self.run_tests)]
