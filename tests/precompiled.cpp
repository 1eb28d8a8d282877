// The library of precompiled headers has to hold something.
