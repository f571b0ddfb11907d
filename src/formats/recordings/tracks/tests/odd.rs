//! Tables as people have them: small ones, each with what is odd about it.

use super::*;

#[test]
fn the_second_table_of_a_recording_may_lack_columns() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let vehicles = file(
        "vehicle_tracks_000.csv",
        "track_id,frame_id,timestamp_ms,agent_type,x,y,vx,vy,psi_rad,length,width\n\
         1,1,100,car,100,50,10,0,0,4.5,1.8\n1,2,200,car,101,50,10,0,0,4.5,1.8\n",
    );
    let pedestrians = file(
        "pedestrian_tracks_000.csv",
        "track_id,frame_id,timestamp_ms,agent_type,x,y,vx,vy\n\
         P1,1,100,pedestrian/bicycle,115,50,0,1\nP1,2,200,pedestrian/bicycle,115,50.1,0,1\n",
    );
    let found = super::super::read(&vehicles).unwrap();
    let scenario = found.open(&vehicles, None, Report::about("t")).unwrap();
    assert_eq!(scenario.obstacles.len(), 2);
    let is_found = |path: &Path| Tables.is_found(path, &std::fs::read(path).unwrap());
    assert!(is_found(&vehicles) && !is_found(&pedestrians));
}
