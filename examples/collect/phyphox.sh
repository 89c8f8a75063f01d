#!/bin/sh
# A phone with phyphox and its remote access switched on: times [s] and accelerations [m/s^2] along y, as lines for `collect -`.
#   sh phyphox.sh 192.168.1.7:8080 | hooke -c 'collect - unit=m/s^2 for=20s; measure period'
while sleep 0.05; do
    curl -s "http://$1/get?acc_time&accY" || exit
    echo
done | sed -u -E 's/.*"acc_time":[^[]*\[([^]]*)\].*/t:\1,&/; s/(t:[^,]*),.*"accY":[^[]*\[([^]]*)\].*/\1,y:\2/'
