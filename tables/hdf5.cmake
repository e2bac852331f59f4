# How the HDF5 library is compiled, read by CMake as its toolchain file (.cargo/config.toml names
# it).

# The folder from which the library would load code if a file asks for an unknown filter or cannot
# be opened. A lone separator is an empty list. By default it is a folder of the build.
set(H5_DEFAULT_PLUGINDIR ":" CACHE STRING "Folders of plug-ins: none")

# The build type that `opt-level = "s"` asks for (Cargo.toml): -O1 compiles in 0.8 of the time of
# -Os, and the checked functions of CFLAGS want an optimised build. Files are read once a run.
set(CMAKE_C_FLAGS_MINSIZEREL "-O1 -DNDEBUG" CACHE STRING "Flags of small builds")
