"""How kernels are compiled, kept on disk, run in threads and interrupted."""
