#!/usr/bin/env bash
# Installs the compilers and libraries of the clients in C++, Go and Java, and what the bridge to ROS is tested with, parts of
# ROS 1 and Mono, from Debian's packages, where they are missing.
set -euo pipefail

packages=(
    g++ pkg-config protobuf-compiler libprotobuf-dev protobuf-compiler-grpc libgrpc++-dev
    golang-go golang-google-grpc-dev golang-google-protobuf-dev golang-google-genproto-dev protoc-gen-go-grpc
    default-jdk-headless protobuf-compiler-grpc-java-plugin libgrpc-java libprotobuf-java libnetty-java libguava-java
    libperfmark-java libgeronimo-annotation-1.3-spec-java
    python3-rospy python3-rosmaster python3-rostopic python3-rosservice python3-rosparam python3-rosbag
    python3-actionlib python3-tf2-ros python3-sensor-msgs python3-nav-msgs python3-std-srvs
    mono-mcs
)
missing=()
for package in "${packages[@]}"; do
    dpkg -s "$package" > /dev/null 2>&1 || missing+=("$package")
done
[ "${#missing[@]}" -gt 0 ] || exit 0
echo "installing ${missing[*]} ..."
as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; else sudo "$@"; fi
}
as_root apt-get update -qq
as_root env DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends "${missing[@]}" > /dev/null
