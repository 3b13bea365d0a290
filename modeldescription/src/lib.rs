//! FMI model descriptions and packages: write, read, check, pack, open
