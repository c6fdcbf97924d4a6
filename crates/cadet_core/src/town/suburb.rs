//! Makes a suburb: its streets as OpenDRIVE.
