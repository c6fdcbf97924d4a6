//! A scene: a town with its traffic and a sensor rig; what Python drives.
