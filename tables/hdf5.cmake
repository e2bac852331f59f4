# How the HDF5 library is compiled, read by CMake as its toolchain file (.cargo/config.toml names
# it).

# The folder from which the library would load code if a file asks for an unknown filter or cannot
# be opened. A lone separator is an empty list. By default it is a folder of the build.
set(H5_DEFAULT_PLUGINDIR ":" CACHE STRING "Folders of plug-ins: none")
